/// \file  People's corrections to the graphs of a set of homes.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "enfilade/graph/corrections.h"

namespace enfilade::homes::sets {

/// Those of one home.
struct HomeCorrections {
  std::filesystem::path file;
  graph::Corrections corrections;
  std::string checksum;  ///< of what they say, however it is laid out; 16 hex digits
};

/// All `<scan>_corrections.json` of a folder, by scan; none for an empty path. \throws FileError if
/// there is no folder or no such file in it; InvalidInput for a broken one, one of another scan
/// than its name says, or of a scan that is none of `scans`
std::map<std::string, HomeCorrections> load_home_corrections(const std::filesystem::path& folder,
                                                             const std::vector<std::string>& scans);

}  // namespace enfilade::homes::sets
