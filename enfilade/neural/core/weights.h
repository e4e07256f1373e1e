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

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/features/tensor_file.h"

namespace enfilade::neural::core {

/// An array that a network needs.
struct ArraySpec {
  std::string name;
  std::vector<std::int64_t> shape;
};
/// The arrays of a linear layer, a normalisation or a convolution: `name`.weight of this shape, and
/// `name`.bias of its first side.
void add_layer(std::vector<ArraySpec>& specs, const std::string& name,
               std::vector<std::int64_t> shape);

using Weights = std::map<std::string, at::Tensor, std::less<>>;  ///< float32, on one device

inline bool nothing(std::string_view /*name*/) { return false; }  ///< for read_weights()
/// Reads the arrays of `wanted` as float32 from any floating-point type. Names are compared without
/// what wrappers put into them (features::bare_name()).
/// \param ignored whether an array of this name may be in the file without being needed
/// \throws InvalidInput naming every array that is missing, surplus, of another shape, not
/// of floating-point type, or not finite
Weights read_weights(const features::TensorFile& file, std::span<const ArraySpec> wanted,
                     bool (*ignored)(std::string_view name) = nothing);

/// Finds a network's sizes in a file, by names that are compared as read_weights() does.
class Shapes {
 public:
  /// \param file outlives this
  explicit Shapes(const features::TensorFile& file);
  const features::NamedArray* find(std::string_view name) const;  ///< null: not in the file
  bool has(std::string_view name) const { return find(name) != nullptr; }
  std::int64_t side(const std::string& name, std::size_t which);  ///< of a matrix; 1 after a fault
  void check();  ///< \throws InvalidInput naming each array without such a side

 private:
  const features::TensorFile& file_;
  std::map<std::string, const features::NamedArray*, std::less<>> arrays_;
  std::vector<Diagnostic> faults_;
};

/// \throws ArgumentError if a network cannot have these sizes
template <class Config>
const Config& checked(const Config& config) {
  validate(config);
  return config;
}

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
struct SavedState {
  std::vector<features::NamedArray> arrays;
  std::vector<std::vector<std::byte>> storage;  ///< what they point into
};
/// Copies for a file.
SavedState as_state(const Weights& weights);

/// Normal distribution around 0, the same on every platform up to the rounding of std::log and
/// std::cos.
at::Tensor normal(const std::vector<std::int64_t>& shape, double deviation, Rng& rng);

/// For a convolution (out, in, k, k) that a ReLU follows (He et al. 2015, forward).
at::Tensor he_normal(const std::vector<std::int64_t>& shape, Rng& rng);

}  // namespace enfilade::neural::core
