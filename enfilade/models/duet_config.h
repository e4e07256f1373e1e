/// \file  The sizes of DUET.
#pragma once
#include <cstdint>
#include <string_view>

namespace enfilade::models {

/// How the scores of the map and of the viewpoint become one.
enum class Fusion : std::uint8_t {
  kDynamic,  ///< a weight that the network computes
  kAverage,  ///< one half each
};
std::string_view to_string(Fusion value) noexcept;  ///< "dynamic", "average"
Fusion parse_fusion(std::string_view name);         ///< \throws ArgumentError

/// Sizes of the network of Chen et al., "Think Global, Act Local: Dual-scale Graph Transformer for
/// Vision-and-Language Navigation" (CVPR 2022). The defaults are the published ones for R2R.
struct DuetConfig {
  std::int64_t hidden = 768;
  std::int64_t heads = 12;                    ///< of each attention; divides `hidden`
  std::int64_t feed_forward = 3072;           ///< inner size of a layer's two linear maps
  std::int64_t panorama_feed_forward = 3072;  ///< likewise, of the panorama's layers
  std::int64_t text_layers = 9;
  std::int64_t panorama_layers = 2;
  std::int64_t cross_layers = 4;  ///< of each of the two branches
  std::int64_t vocabulary = 30522;
  std::int64_t positions = 512;  ///< of words
  std::int64_t token_types = 2;
  std::int64_t steps = 100;  ///< rows of the table of step numbers
  std::int64_t image = 768;  ///< columns of a view's features
  std::int64_t object = 0;   ///< columns of an object's features; 0: no objects
  Fusion fusion = Fusion::kDynamic;
  bool map_distances = true;      ///< the map's distances bias the attention among its nodes
  std::int64_t max_words = 200;   ///< per instruction, those at both ends included
  std::int64_t max_actions = 15;  ///< per episode; the last one always stops.
  /// A trajectory ends where the agent has stopped by itself, and not where stopping was most
  /// probable.
  bool stays_where_it_stops = false;
  double dropout = 0.1;          ///< within the network, in training
  double feature_dropout = 0.4;  ///< of image and object features, in training

  /// The object features have linear maps of their own.
  bool own_object_map() const noexcept { return object != 0 && object != image; }
};

/// "duet" (as published) or "duet-s" (a small one for two CPU cores).
/// \throws ArgumentError for another name, naming those that there are
DuetConfig duet_preset(std::string_view name);

/// \throws ArgumentError naming the first impossible size, and the possible ones
void validate(const DuetConfig& config);

}  // namespace enfilade::models
