/// \file  The annotation files in a folder of homes; the next run removes old ones.
#pragma once
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace enfilade::homes::sets {

/// Writes annotation files and lists them in `annotations.txt`, one path per line. At the end,
/// files of an earlier run's list that this run does not write are removed, with folders that
/// become empty. So other seeds and fewer tasks leave nothing behind. Files of users in these
/// folders are in no list, and stay.
class WrittenFiles {
 public:
  explicit WrittenFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Writes `<folder>/<file>`, whole or not at all. \param file  relative \throws FileError
  void write(const std::filesystem::path& file, std::string_view text);

  /// Removes old files and writes the list. \throws FileError; InvalidInput for a list that names
  /// anything that is not below the folder
  void finish();

 private:
  std::filesystem::path folder_;
  std::set<std::string> files_;
};

}  // namespace enfilade::homes::sets
