/// \file  Named arrays in files: weights and features.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/enum_names.h"

namespace enfilade::features {

/// Type of the elements of an array.
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
std::size_t size_of(DType type) noexcept;  ///< bytes of an element
/// As in safetensors.
constexpr std::array<std::string_view, 9> names_of(DType /*enum*/) {
  return {"F16", "BF16", "F32", "F64", "I32", "I64", "U8", "U64", "BOOL"};
}

/// One array: contiguous, row-major, little-endian. Does not own its bytes; those of a TensorFile
/// are aligned for their type and valid as long as the file.
struct NamedArray {
  std::string name;
  DType type = DType::kFloat32;
  std::vector<std::int64_t> shape;   ///< empty: a scalar
  std::span<const std::byte> bytes;  ///< product of shape times size_of(type)

  std::size_t elements() const noexcept;  ///< product of shape
};

/// The arrays of a file of weights, memory-mapped if the format allows. Immutable: any thread.
/// Reads
/// - safetensors (https://github.com/huggingface/safetensors, "Format")
/// - NumPy's `.npz` (zip archives of `.npy`, named by their paths without ".npy")
/// - dictionaries of tensors written by PyTorch's torch.save(): zip archives (since 1.6) and the
///   older plain pickles
///
/// From a pickle only a dictionary's tensors are built; no code that it names is ever run. In a
/// checkpoint the dictionary below "state_dict", "model_state_dict", "model" or "module" is read,
/// whatever lies beside it. A checkpoint of several networks ({"encoder": {"state_dict": ...},
/// ...}) gives those of all, named "encoder.<name>" (once, and as bare_name()). A TorchScript
/// module gives the tensors of all modules in it. docs/features.md has more.
class TensorFile {
 public:
  /// Detects the format by content. \throws FileError; InvalidInput naming the array or the byte,
  /// also if none of the file's arrays can be read
  static TensorFile open(const std::filesystem::path& file);

  std::span<const NamedArray> arrays() const noexcept;  ///< by name; valid as long as *this
  const NamedArray* find(std::string_view name) const noexcept;  ///< null for an unknown name.
  /// Arrays of the file that are not read, with the reason: a type of numbers that DType lacks, or
  /// code that would have to run.
  const std::map<std::string, std::string>& left_out() const noexcept;
  /// safetensors' `__metadata__`. For a checkpoint of PyTorch, the fields beside "state_dict" (or
  /// the other name of it); in one of several networks as "<network>.epoch". They are digits of a
  /// whole number, else an empty text. Empty for others.
  const std::map<std::string, std::string>& metadata() const noexcept;
  const std::filesystem::path& path() const noexcept;
  /// The same arrays, also those left out, by other names, which may be equal. Shares the memory.
  TensorFile renamed(std::string (*name)(std::string_view)) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

/// A name without what PyTorch's wrappers put into it: "module." (data parallel), "_orig_mod."
/// (torch.compile()) and "model." (a Lightning module's attribute) at the start, in any order and
/// number; "_orig_mod.", "_fsdp_wrapped_module." and "_checkpoint_wrapped_module." anywhere.
std::string bare_name(std::string_view name);

/// Writes safetensors. Writes to `<file>.part` first and then renames it, so `file` is complete or
/// unchanged, even after a power failure. Arrays whose size is a multiple of 64 bytes come first,
/// at offsets that are multiples of 64. The others follow, at multiples of their element's size, as
/// the format allows no gaps. The same input gives the same bytes.
/// \throws FileError, also for a full disk, a file that another process is writing, or one that is
/// not a regular file
/// \throws ArgumentError for equal names, bytes that do not fit the shape, or text that is not
/// UTF-8
void write_safetensors(const std::filesystem::path& file, std::span<const NamedArray> arrays,
                       const std::map<std::string, std::string>& metadata = {});

}  // namespace enfilade::features
