/// \file  Image encoders that are Vision Transformers (Dosovitskiy et al. 2021), for inference.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/geometry/camera.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/encoder.h"

namespace enfilade::neural::encoders {

/// torchvision's `Resize(shorter, BICUBIC)` of a Pillow picture, then `CenterCrop(crop)`.
/// Immutable: any thread.
class PictureResize {
 public:
  /// \param shorter the shorter side after resizing, in pixels; at least `crop`
  PictureResize(const Camera& from, std::uint32_t shorter, std::uint32_t crop);

  const Camera& from() const noexcept { return from_; }

  /// Float32 on the CPU, (n, 3, crop, crop), whole numbers from 0 to 255. Equal to Pillow's in
  /// each number: the same whole-number weights, rounded after each of the two passes.
  /// \param pictures (n, 3, height, width) of from(), whole numbers from 0 to 255
  at::Tensor apply(std::span<const float> pictures, std::size_t n) const;

 private:
  // The sources of one row or column of the result.
  struct ResizeTaps {
    std::size_t first = 0;
    std::vector<std::int32_t> weights;  // in units of 2^-22
  };
  static std::vector<ResizeTaps> taps(std::size_t from, std::size_t to, std::size_t crop);
  void resize_plane(std::span<const float> plane, std::span<float> out) const;

  Camera from_;
  std::size_t crop_;
  std::vector<ResizeTaps> columns_, rows_;
};

/// Activation of a block's hidden layer.
enum class Activation : std::uint8_t {
  kGelu,       ///< x times the normal distribution's share below x
  kQuickGelu,  ///< x times the logistic function of 1.702 x, as in CLIP
};

/// Sizes and constants; as they stand, those of ViT-B/16.
struct TransformerSizes {
  std::int64_t picture = 224, patch = 16;  ///< pixels a side
  std::int64_t width = 768, layers = 12, heads = 12, hidden = 3072;
  double epsilon = 1e-6;  ///< of the layer normalisations
  Activation activation = Activation::kGelu;

  /// The patches of a picture, and one token more for the picture as a whole.
  std::int64_t tokens() const noexcept { return (picture / patch) * (picture / patch) + 1; }
};

/// A linear layer. The bias may be undefined: none.
struct Linear {
  at::Tensor weight;  ///< (out, in)
  at::Tensor bias;    ///< (out)
};
/// A layer normalisation; undefined arrays: none.
struct LayerNorm {
  at::Tensor weight, bias;  ///< (width)
};
/// One block: x += proj(attention(norm1(x))), then x += fc2(activation(fc1(norm2(x)))).
struct TransformerBlock {
  LayerNorm norm1;
  Linear qkv;   ///< (3 width, width): queries, keys, values
  Linear proj;  ///< (width, width)
  LayerNorm norm2;
  Linear fc1;  ///< (hidden, width)
  Linear fc2;  ///< (width, hidden)
};
/// All arrays of a network, float32.
struct TransformerArrays {
  Linear patches;          ///< (width, 3 patch patch)
  at::Tensor class_token;  ///< (width)
  at::Tensor positions;    ///< (tokens, width)
  LayerNorm before;        ///< ahead of the blocks: CLIP's; undefined in ViT
  std::vector<TransformerBlock> blocks;
  LayerNorm after;  ///< of the picture's token, behind the blocks
};

/// Arrays on a device, ready to run. Immutable: any thread.
class VisionTransformer {
 public:
  VisionTransformer(const TransformerSizes& sizes, const TransformerArrays& arrays,
                    c10::Device device);

  c10::Device device() const noexcept { return device_; }

  /// The picture's token behind the last normalisation: (n, width). The last block computes that
  /// token only, which is all that is read of it.
  /// \param pictures (n, 3, picture, picture), normalised, on device()
  at::Tensor run(const at::Tensor& pictures) const;

 private:
  at::Tensor embed(const at::Tensor& pictures) const;
  at::Tensor attend(const TransformerBlock& block, const at::Tensor& x, std::int64_t rows) const;
  at::Tensor run(const TransformerBlock& block, const at::Tensor& x, std::int64_t rows) const;

  TransformerSizes sizes_;
  c10::Device device_;
  TransformerArrays arrays_;
};

/// x (rows, in) through a linear layer.
at::Tensor apply(const Linear& linear, const at::Tensor& x);

/// How a family of networks names its arrays in files.
struct TransformerNames {
  std::string class_token, positions, patches, before, after;  ///< `before` may be empty: none
  std::string block;  ///< in front of a block's names, with {} for its number
  std::string norm1, qkv_weight, qkv_bias, proj, norm2, fc1, fc2;
  bool patch_bias = true;    ///< whether there is "<patches>.bias"
  bool leading_ones = true;  ///< token and positions have shapes (1, 1, width), (1, n, width)
};
/// The arrays of a network by these names, with their shapes in files.
std::vector<core::ArraySpec> transformer_arrays(const TransformerNames& names,
                                                const TransformerSizes& sizes);
/// The same arrays of `weights`, by their places in the network. \pre all are there
TransformerArrays arrays_of(const TransformerNames& names, const TransformerSizes& sizes,
                            const core::Weights& weights);

/// Everything that an encoder has beside its device.
struct TransformerParts {
  TransformerSizes sizes;
  TransformerArrays arrays;
  std::string preprocessing;  ///< for the feature file
  std::uint32_t shorter = 0;  ///< pixels of the shorter side, before the middle is cut out
  render::Normalisation normalisation;
  Linear output;        ///< behind the picture's token; undefined: none
  bool beside = false;  ///< whether the features are the token and then the output
  std::string hash;     ///< of the weights
};

/// An encoder of 640 x 480 pictures; it takes those of any other camera too.
std::unique_ptr<ImageEncoder> make_transformer_encoder(TransformerParts parts, c10::Device device);

/// Arrays of these names and shapes with random values, as the networks begin their training. They
/// are normal with a deviation of 0.02. Normalisations are the identity and biases 0.
core::Weights random_transformer(std::span<const core::ArraySpec> arrays, std::uint64_t seed);

}  // namespace enfilade::neural::encoders
