/// \file  A network's weights from a file, checked and converted to tensors.
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/features/tensor_file.h"

namespace enfilade::neural::core {

/// An array that a network needs.
struct ArraySpec {
  std::string name;
  std::vector<std::int64_t> shape;
};

using Weights = std::map<std::string, at::Tensor, std::less<>>;  ///< float32, on one device

/// Reads the arrays of `wanted` as float32 from any floating-point type. The prefix "module." of
/// PyTorch's data-parallel wrapper is ignored.
/// \param ignored whether an array of this name may be in the file without being needed
/// \throws InvalidInput naming every array that is missing, surplus, of another shape, not
/// of floating-point type, or not finite
Weights read_weights(const features::TensorFile& file, std::span<const ArraySpec> wanted,
                     bool (*ignored)(std::string_view name));

/// Random or read weights for training: on this device, and requiring gradients.
void make_trainable(Weights& weights, c10::Device device);
/// Values without gradients; those on the CPU share their memory.
Weights on_cpu(const Weights& weights);

/// 16 hex digits of XXH3 over names and values in the order of names. \pre float32, contiguous, on
/// the CPU
std::string hash_of(const Weights& weights);

/// Views for write_safetensors(), valid as long as the tensors. \pre as hash_of()
std::vector<features::NamedArray> as_arrays(const Weights& weights);

/// Arrays of a file, and the memory that they lie in.
struct State {
  std::vector<features::NamedArray> arrays;
  std::vector<std::vector<std::byte>> storage;  ///< what they point into
};
/// Copies for a file.
State as_state(const Weights& weights);

}  // namespace enfilade::neural::core
