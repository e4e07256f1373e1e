/// \file  The safetensors format (https://github.com/huggingface/safetensors, "Format").
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "enfilade/features/formats/stored_arrays.h"

namespace enfilade::features::formats {

/// The arrays lie in `file` wherever their type allows it. \throws InvalidInput
StoredArrays read_safetensors(std::span<const std::byte> file, const std::string& name);

/// Where everything goes in a file of arrays whose bytes may not be known yet.
struct SafetensorsLayout {
  std::string start;                   ///< of the file: length, header, padding
  std::vector<std::uint64_t> offsets;  ///< from the start of the file, an array each
  std::uint64_t file_bytes = 0;
};
/// Only names, types and shapes of the arrays are looked at. \throws ArgumentError for equal names,
/// a name or metadata that is no UTF-8, or too many arrays for a header of 100 MB
SafetensorsLayout lay_out_safetensors(std::span<const NamedArray> arrays,
                                      const std::map<std::string, std::string>& metadata);

}  // namespace enfilade::features::formats
