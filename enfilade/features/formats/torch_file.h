/// \file  Dictionaries of tensors written by PyTorch's torch.save().
#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "enfilade/features/formats/stored_arrays.h"

namespace enfilade::features::formats {

/// By its first bytes.
bool looks_like_zip(std::span<const std::byte> file) noexcept;
/// A pickle of any program.
bool looks_like_pickle(std::span<const std::byte> file) noexcept;

/// Reads a zip archive, the format since PyTorch 1.6. \throws FileError, InvalidInput
StoredArrays read_torch_zip(const std::filesystem::path& file);

/// Reads a pickle followed by storages, the format until PyTorch 1.5. Arrays that are contiguous
/// and aligned point into `file`. \throws InvalidInput
StoredArrays read_torch_pickle(std::span<const std::byte> file, const std::string& name);

}  // namespace enfilade::features::formats
