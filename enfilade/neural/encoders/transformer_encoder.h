/// \file  Image encoders that are Vision Transformers.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/encoder.h"
#include "enfilade/neural/encoders/vision_transformer.h"

namespace enfilade::neural::encoders {

/// Preparation of a picture for the network.
struct Preparation {
  std::string name;           ///< for the feature file
  std::uint32_t shorter = 0;  ///< pixels of the shorter side, before the middle is cut out
  render::Normalisation normalisation;
};

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
  Preparation preparation;
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
