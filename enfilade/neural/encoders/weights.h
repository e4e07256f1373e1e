/// \file  Weights out of files: checked against what a network needs, as tensors.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/features/tensor_file.h"

namespace enfilade::neural::encoders {

struct ArraySpec {
  std::string name;
  std::vector<std::int64_t> shape;
};

using Weights = std::map<std::string, at::Tensor, std::less<>>;  ///< float32, on the CPU

/// The arrays of `wanted` as float32, whatever floating-point type the file has. A "module." before
/// all names, as PyTorch's data-parallel wrapper leaves it, is not looked at.
/// \param ignored names of arrays that may be there and are not needed
/// \throws InvalidInput naming every array that is missing, surplus, of another shape, no
/// floating-point numbers, or not finite
Weights read_weights(const features::TensorFile& file, std::span<const ArraySpec> wanted,
                     bool (*ignored)(std::string_view name));

/// 16 hex digits of XXH3 over names and values in the order of names. \pre float32, contiguous
std::string hash_of(const Weights& weights);

/// As NamedArray's for write_safetensors(); valid as long as the tensors. \pre as hash_of()
std::vector<features::NamedArray> as_arrays(const Weights& weights);

}  // namespace enfilade::neural::encoders
