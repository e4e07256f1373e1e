/// \file  What PyTorch's torch.save() makes of a dictionary of tensors.
#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "enfilade/features/formats/stored_arrays.h"

namespace enfilade::features::formats {

bool looks_like_zip(std::span<const std::byte> file) noexcept;
/// A pickle of any kind, torch.save()'s or not.
bool looks_like_pickle(std::span<const std::byte> file) noexcept;

/// Archives, as of PyTorch 1.6. \throws FileError, InvalidInput
StoredArrays read_torch_zip(const std::filesystem::path& file);

/// Pickles with storages behind them, as until PyTorch 1.5. The arrays lie in `file` where they are
/// contiguous and aligned there. \throws InvalidInput
StoredArrays read_torch_pickle(std::span<const std::byte> file, const std::string& name);

}  // namespace enfilade::features::formats
