/// \file  The layout of safetensors (https://github.com/huggingface/safetensors, "Format").
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "enfilade/features/tensor_file.h"

namespace enfilade::features::formats {

/// The layout of a file, whose arrays' bytes need not be known yet.
struct SafetensorsLayout {
  std::string start;                   ///< beginning of the file: length, header, padding
  std::vector<std::uint64_t> offsets;  ///< of each array, from the start of the file
  std::uint64_t file_bytes = 0;
};
/// Uses names, types and shapes of the arrays only. \throws ArgumentError for equal names, a name
/// or metadata that is not UTF-8, or too many arrays for a header of 100 MB
SafetensorsLayout lay_out_safetensors(std::span<const NamedArray> arrays,
                                      const std::map<std::string, std::string>& metadata);

}  // namespace enfilade::features::formats
