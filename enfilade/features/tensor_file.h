/// \file  Named arrays in files: weights and features.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::features {

/// Type of a tensor's numbers.
enum class DType : std::uint8_t {
  kFloat16,
  kBFloat16,
  kFloat32,
  kFloat64,
  kInt32,
  kInt64,
  kUint8,
  kUint64,
  kBool,
};
std::size_t size_of(DType type) noexcept;         ///< bytes an element
std::string_view to_string(DType type) noexcept;  ///< as safetensors has it: "F16", "I64"

/// One array: contiguous, row-major, little-endian. A view: whoever holds the bytes keeps them.
/// Those of a TensorFile are aligned for their type.
struct NamedArray {
  std::string name;
  DType type = DType::kFloat32;
  std::vector<std::int64_t> shape;   ///< empty: a scalar
  std::span<const std::byte> bytes;  ///< product of shape times size_of(type)

  std::size_t elements() const noexcept;  ///< product of shape
};

/// The arrays of a file of weights, memory-mapped where the format allows. Immutable: any thread.
/// Reads safetensors (https://github.com/huggingface/safetensors, "Format") and what PyTorch's
/// torch.save() makes of a dictionary of tensors: zip archives (since 1.6) and the older plain
/// pickles. Only a dictionary's tensors are built from a pickle; it can name no other code. Of a
/// training program's checkpoint, the dictionary below "state_dict", "model_state_dict", "model" or
/// "module" is taken. docs/features.md has more.
class TensorFile {
 public:
  /// Tells the format by content. \throws FileError; InvalidInput naming the array or the place
  static TensorFile open(const std::filesystem::path& file);

  std::span<const NamedArray> arrays() const noexcept;  ///< by name; valid as long as *this
  const NamedArray* find(std::string_view name) const noexcept;  ///< null if there is none
  /// safetensors' `__metadata__`; empty for others.
  const std::map<std::string, std::string>& metadata() const noexcept;
  const std::filesystem::path& path() const noexcept;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

/// Writes safetensors, by way of `<file>.part`, so that `file` is whole or as before, also after a
/// power cut. Arrays of a multiple of 64 bytes begin at multiples of 64 of the file; the others,
/// which come behind, at multiples of their element's size, as the format allows no gaps. Same
/// input, same bytes. \throws FileError (a full disk too; another process writing the file; a
/// `file` that is no plain one); ArgumentError for equal names, bytes that do not fit a shape, or
/// text that is no UTF-8
void write_safetensors(const std::filesystem::path& file, std::span<const NamedArray> arrays,
                       const std::map<std::string, std::string>& metadata = {});

}  // namespace enfilade::features
