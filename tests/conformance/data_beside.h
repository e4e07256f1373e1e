/// \file  Where the data is that recorded files (vectors, traces) speak of.
#pragma once
#include <filesystem>
#include <string>

#include "apps/common/program.h"

namespace enfilade::tests {

/// `data` (of --data) if it is given; else ENFILADE_DATA; else `../data` beside the recorded file's
/// folder, where those who hand out both have it.
/// \throws UsageError that says where the data is had; FileError if `data` names no folder
inline dataset::Dataset open_data_beside(const std::string& data,
                                         const std::filesystem::path& file) {
  if (data.empty() && !dataset::Dataset::from_environment()) {
    const auto beside = std::filesystem::absolute(file).parent_path().parent_path() / "data";
    if (std::filesystem::is_directory(beside)) return dataset::Dataset(beside);
  }
  return apps::open_data(data);
}

}  // namespace enfilade::tests
