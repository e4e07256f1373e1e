/// \file  Readers of files of weights, their result, and the layout of safetensors
/// (https://github.com/huggingface/safetensors, "Format").
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/features/tensor_file.h"

namespace enfilade::features::formats {

/// Arrays, and the memory that they point into.
struct StoredArrays {
  std::vector<NamedArray> arrays;
  std::map<std::string, std::string> metadata;
  std::map<std::string, std::string> left_out;      ///< names of arrays that are not read, and why
  std::vector<std::shared_ptr<const void>> memory;  ///< of arrays that are not in the mapped file

  /// The bytes themselves if they are aligned for the type, else a copy.
  std::span<const std::byte> aligned(std::span<const std::byte> bytes, DType type);
  /// Uninitialised memory, valid as long as *this.
  std::span<std::byte> allocate(std::size_t bytes);
};

/// Safetensors. Arrays point into `file` where they are aligned for their type. Those of another
/// type are left out, if there are others.
/// \throws InvalidInput
StoredArrays read_safetensors(std::span<const std::byte> file, const std::string& name);

/// The layout of a safetensors file, whose arrays' bytes need not be known yet.
struct SafetensorsLayout {
  std::string start;                   ///< beginning of the file: length, header, padding
  std::vector<std::uint64_t> offsets;  ///< of each array, from the start of the file
  std::uint64_t file_bytes = 0;
};
/// Uses names, types and shapes of the arrays only.
/// \throws ArgumentError for equal names, a name or metadata that is not UTF-8, or too many arrays
/// for a header of 100 MB
SafetensorsLayout lay_out_safetensors(std::span<const NamedArray> arrays,
                                      const std::map<std::string, std::string>& metadata);

// Dictionaries of tensors written by PyTorch's torch.save(), detected by the first bytes.
bool looks_like_zip(std::span<const std::byte> file) noexcept;
/// A pickle of any program.
bool looks_like_pickle(std::span<const std::byte> file) noexcept;
/// A tar archive of any program.
bool looks_like_tar(std::span<const std::byte> file) noexcept;
/// torch.save()'s first format, until PyTorch 0.1.8, is not read. \throws InvalidInput, with the
/// line of Python that converts it
[[noreturn]] void refuse_tar(std::span<const std::byte> file, const std::string& name);
/// A zip archive, the format since PyTorch 1.6. \throws FileError, InvalidInput
StoredArrays read_torch_zip(const std::filesystem::path& file);
/// A pickle followed by storages, the format until PyTorch 1.5. Arrays that are contiguous and
/// aligned point into `file`. \throws InvalidInput
StoredArrays read_torch_pickle(std::span<const std::byte> file, const std::string& name);

/// Bytes of an array; none if they exceed size_t.
std::optional<std::size_t> bytes_of_shape(std::span<const std::int64_t> shape, DType type) noexcept;

}  // namespace enfilade::features::formats
