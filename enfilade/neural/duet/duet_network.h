/// \file  The dual-scale graph transformer DUET: text, panorama, map and viewpoint; its arrays and
/// layers.
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/models/network_config.h"
#include "enfilade/neural/core/dropout.h"
#include "enfilade/neural/core/weights.h"

namespace enfilade::neural::duet {

using models::duet_preset;
using models::DuetConfig;
using models::Fusion;

/// Numbers of a token's location: an angle feature of 4, and height, width and area of a box.
inline constexpr std::int64_t kLocation = 7;
/// Numbers of a position on the map: an angle feature of 4, two distances, hops.
inline constexpr std::int64_t kPosition = 7;

/// The sizes behind a file of weights, from its arrays' names and shapes. The number of heads is in
/// no shape: it is hidden / 64, as in all published networks, unless `heads` is given.
/// \throws InvalidInput naming every array that is needed for it and missing or of another rank
DuetConfig infer_config(const features::TensorFile& file, std::int64_t heads = 0);

/// The arrays of a network by their published names ("vln_bert.embeddings.LayerNorm.weight").
std::vector<core::ArraySpec> arrays_of(const DuetConfig& config);

/// Dropout at the network's rate, or at another one.
class RateDropout {
 public:
  /// \param rate share of numbers that become 0, in [0, 1)
  RateDropout(std::uint64_t seed, double rate, c10::Device device = c10::kCPU)
      : drop_(seed, device), rate_(rate) {}
  at::Tensor operator()(const at::Tensor& values) { return drop_(values, rate_); }
  at::Tensor operator()(const at::Tensor& values, double rate) { return drop_(values, rate); }
  at::Tensor mask(at::IntArrayRef sizes) { return drop_.mask(sizes, rate_); }
  double rate() const noexcept { return rate_; }

 private:
  core::Dropout drop_;
  double rate_;
};

inline constexpr double kBertEpsilon = 1e-12;  ///< of BERT's norms

/// Summand of an attention's scores of padding.
inline constexpr double kSoftMask = -10000;
/// Summand of an attention's scores: 0 for tokens, `padding` elsewhere.
/// \param mask (n, length) bool, true for a token
/// \return (n, 1, 1, length)
at::Tensor bias_of(const at::Tensor& mask, double padding);

/// Keys and values of an attention, as its layer needs them.
struct Attended {
  at::Tensor keys, values;  ///< (n, b, hidden)
};

/// The layers of one network. `dropout` may be null: then there is none.
class Layers {
 public:
  Layers(const core::Weights& weights, std::int64_t heads, RateDropout* dropout)
      : weights_(weights), heads_(heads), dropout_(dropout) {}

  const at::Tensor& weight(const std::string& name) const;
  at::Tensor drop(const at::Tensor& values) const;
  at::Tensor linear(const at::Tensor& x, const std::string& name) const;
  at::Tensor norm(const at::Tensor& x, const std::string& name, double eps = kBertEpsilon) const;

  /// Attention of `x` (n, a, hidden) to `to` (n, b, hidden), then sum and norm.
  /// \param bias added to the scores, as (n, 1, a or 1, b)
  at::Tensor attention(const at::Tensor& x, const at::Tensor& to, const at::Tensor& bias,
                       const std::string& inner, const std::string& output) const;
  /// The same in two parts: keys and values may be the same in many calls.
  Attended attended(const at::Tensor& to, const std::string& inner) const;
  at::Tensor attention(const at::Tensor& x, const Attended& to, const at::Tensor& bias,
                       const std::string& inner, const std::string& output) const;
  /// Two linear maps with GELU (of erf) between them, then sum and norm.
  at::Tensor feed_forward(const at::Tensor& x, const std::string& inner,
                          const std::string& output) const;
  /// A layer that norms first, with torch.nn.MultiheadAttention's parameters.
  /// \param bias as in attention(); minus infinity for padding
  at::Tensor pre_norm_layer(const at::Tensor& x, const at::Tensor& bias,
                            const std::string& name) const;
  /// Linear, ReLU, norm, linear to one number: (..., hidden) -> (...).
  at::Tensor head(const at::Tensor& x, const std::string& name) const;

 private:
  at::Tensor attend(const at::Tensor& query, const at::Tensor& key, const at::Tensor& value,
                    const at::Tensor& bias) const;
  // norm(drop(y) + x)
  at::Tensor sum_norm(const at::Tensor& y, const at::Tensor& x, const std::string& name) const;
  // Factors of dropout; undefined: none.
  at::Tensor mask(at::IntArrayRef sizes) const;

  const core::Weights& weights_;
  std::int64_t heads_;
  RateDropout* dropout_;
};

/// Vectors of n rows padded to a common length, and how many of each row are there.
struct Tokens {
  at::Tensor values;  ///< (n, longest, hidden); what stands at padding means nothing
  at::Tensor mask;    ///< (n, longest) bool, true for a token
};

/// Texts for many calls of navigate(): what each cross layer makes of them is made once.
struct PreparedText {
  at::Tensor mask;                       ///< as Tokens
  std::vector<Attended> map, viewpoint;  ///< by layer of each branch

  /// Rows of some of the texts. \param which (m) int64
  PreparedText rows(const at::Tensor& which) const;
};

/// Panoramas as tokens: views, then at once each row's own objects, then padding.
struct PanoramaInput {
  at::Tensor views;          ///< (n, views, image)
  at::Tensor view_counts;    ///< (n) int64
  at::Tensor objects;        ///< (n, objects, object); not defined without objects
  at::Tensor object_counts;  ///< (n) int64; not defined without objects
  at::Tensor locations;      ///< (n, longest, 7)
  at::Tensor types;          ///< (n, longest) int64: 0 view, 1 candidate, 2 object

  PanoramaInput on(c10::Device device) const;  ///< tensors on the device already are not copied
};

/// Input of the two branches. Row 0 of map and viewpoint is "stop".
struct NavigationInput {
  at::Tensor nodes;            ///< (n, g, hidden) embeddings of the map's nodes; zeros for stop
  at::Tensor steps;            ///< (n, g) int64: 0, or 1 + the step that visited the node
  at::Tensor node_positions;   ///< (n, g, 7)
  at::Tensor node_mask;        ///< (n, g) bool
  at::Tensor visited;          ///< (n, g) bool
  at::Tensor distances;        ///< (n, g, g) metres; row and column 0 are 0
  at::Tensor tokens;           ///< (n, v, hidden): zeros for stop, then the panorama's tokens
  at::Tensor token_positions;  ///< (n, v, 14)
  at::Tensor token_mask;       ///< (n, v) bool
  at::Tensor choices;          ///< (n, v) bool: stop and candidates
  at::Tensor objects;          ///< (n, v) bool; not defined without objects
  /// (n, v) int64: the map's row of a candidate, -1 for all else. Row 0 is no candidate's.
  at::Tensor node_of_token;

  NavigationInput on(c10::Device device) const;  ///< tensors on the device already are not copied
};

/// Output of the two branches. Logits of impossible choices are minus infinity.
struct NavigationOutput {
  at::Tensor nodes, tokens;                ///< embeddings after the last layer
  at::Tensor fuse_weight;                  ///< (n, 1) the map's share
  at::Tensor global_scores, local_scores;  ///< the heads' outputs, before weight and mask
  at::Tensor global_logits;                ///< (n, g)
  at::Tensor local_logits;                 ///< (n, v)
  at::Tensor fused_logits;                 ///< (n, g)
  at::Tensor object_logits;                ///< (n, v); not defined without objects
};

/// The network's parameters and what they compute, on one device; inputs may be on any. Autograd
/// follows every call, unless a guard is set. One thread at a time.
class DuetNetwork {
 public:
  /// Random weights by `seed`: normal of deviation 0.02 as in BERT; the packed maps of the
  /// panorama's attention uniform as in PyTorch. \throws ArgumentError as validate()
  DuetNetwork(const DuetConfig& config, std::uint64_t seed, c10::Device device = c10::kCPU);
  /// The weights of a checkpoint of the published code, or of arrays by the
  /// same names. Arrays of its critic are ignored.
  /// \throws InvalidInput naming every missing, surplus and wrong-shaped array
  DuetNetwork(const DuetConfig& config, const features::TensorFile& file,
              c10::Device device = c10::kCPU);

  const DuetConfig& config() const noexcept { return config_; }
  const core::Weights& weights() const noexcept { return weights_; }
  c10::Device device() const noexcept { return device_; }

  /// \param ids (n, longest) int64, any value at padding that is in the vocabulary
  /// \param lengths (n) int64
  Tokens encode_text(const at::Tensor& ids, const at::Tensor& lengths,
                     RateDropout* dropout = nullptr) const;
  Tokens encode_panorama(const PanoramaInput& input, RateDropout* dropout = nullptr) const;
  /// A third of a step's work on the text is the same in every step of an episode.
  PreparedText prepare(const Tokens& text) const;
  NavigationOutput navigate(const PreparedText& text, const NavigationInput& input,
                            RateDropout* dropout = nullptr) const;
  NavigationOutput navigate(const Tokens& text, const NavigationInput& input,
                            RateDropout* dropout = nullptr) const {
    return navigate(prepare(text), input, dropout);
  }
  /// Input of a branch's first layer, each with its position: nodes of the map (n, g, hidden), or
  /// tokens of the viewpoint (n, v, hidden). Called by navigate().
  at::Tensor embed_nodes(const NavigationInput& input) const;
  at::Tensor embed_tokens(const NavigationInput& input) const;  ///< likewise

 private:
  at::Tensor branch(const Layers& layers, at::Tensor x, const PreparedText& text,
                    const std::vector<Attended>& words, const at::Tensor& mask,
                    const at::Tensor& bias, const char* name) const;
  void fuse(const Layers& layers, const NavigationInput& input, NavigationOutput& out) const;

  DuetConfig config_;
  core::Weights weights_;
  c10::Device device_;
};

/// Random weights on the CPU, as the constructor of DuetNetwork begins with them.
core::Weights random_weights(std::span<const core::ArraySpec> specs, Rng rng);

/// (n, longest) bool: the first lengths[i] of row i.
at::Tensor mask_of(const at::Tensor& lengths, std::int64_t longest);

}  // namespace enfilade::neural::duet
