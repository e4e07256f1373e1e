/// \file  Whole folders, to be compared.
#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "enfilade/core/file.h"

namespace enfilade::tests {

/// Every file below a folder: its path in it and its bytes.
inline std::map<std::string, std::string> content_of(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[std::filesystem::relative(entry.path(), folder).string()] = read_file(entry.path());
  }
  return files;
}

}  // namespace enfilade::tests
