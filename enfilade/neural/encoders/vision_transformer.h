/// \file  The Vision Transformer (Dosovitskiy et al. 2021) for inference, of any size.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <vector>

namespace enfilade::neural::encoders {

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

}  // namespace enfilade::neural::encoders
