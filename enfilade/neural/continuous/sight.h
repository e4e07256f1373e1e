/// \file  The agent's observation at a step: features of a picture, and a coarse depth picture.
#pragma once
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/agents/continuous_agent.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/neural/continuous_agent.h"

namespace enfilade::neural::continuous {

/// Observations of n steps, as files of rollouts store them.
struct Seen {
  std::vector<std::uint16_t> pictures;  ///< (n, features) halves
  std::vector<std::uint8_t> depth;      ///< (n, kDepthSize) 255: 10 m and more, or no surface
};

/// Draws and encodes. Pictures are those that the encoder was made for: of `home` 128 x 96, of
/// ResNets VLN-CE's 224 x 224 at 90 degrees. Depth is drawn with 64 x 64 pixels at 90 degrees, cut
/// off at 10 m, of which cells of 4 x 4 keep the mean. One thread at a time.
class Sight {
 public:
  /// \throws ArgumentError without a scene_of; as make_encoder()
  explicit Sight(const ContinuousSight& config);

  /// Source of its features: the encoder, its weights, the camera.
  features::FeatureInfo info() const;
  /// The observations of the episodes `rows` of a batch, one after another.
  /// \param eye_height metres above the feet
  /// \throws as scene_of, Eyes::render()
  Seen look(std::span<const agents::ContinuousObservation> batch, std::span<const std::size_t> rows,
            double eye_height);

 private:
  enfilade::continuous::Eyes& eyes_of(const std::string& scan);
  void draw(const std::string& scan, std::span<const enfilade::continuous::MeshView> views,
            std::span<float> pictures, std::span<float> depth);

  // The recent buildings, the last one first.
  struct Known {
    std::string scan;
    std::unique_ptr<enfilade::continuous::Eyes> eyes;
  };
  ContinuousSight config_;
  std::unique_ptr<ImageEncoder> encoder_;
  Camera camera_;
  std::list<Known> known_;
};

}  // namespace enfilade::neural::continuous
