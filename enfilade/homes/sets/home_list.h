/// \file  Files in a folder of synthetic homes: its list `homes.json` with the names of its scans.
/// Its annotations, of which the next run removes old ones.
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/output_folder.h"
#include "enfilade/homes/home_set.h"

namespace enfilade::homes::sets {

struct HomeList {
  HomeSetOptions options;  ///< `threads` is not kept
  std::vector<HomeEntry> homes;
};

std::string to_json(const HomeList& list);
/// \throws InvalidInput
HomeList parse_home_list(std::string_view json, const std::string& file);

/// The first option that differs, as text with both values; empty if none does.
std::string difference(const HomeSetOptions& a, const HomeSetOptions& b);

/// "home0001" for 0. Without "_", at which CLIP-ViL and others split keys of scan and viewpoint.
std::string scan_name(std::size_t home);
/// The place of a home from its name; no value for other texts.
std::optional<std::size_t> place_of_scan(const std::string& scan);
/// Seed text of the ids of viewpoints, paths and headings of a home: its name in the first
/// versions, so that they stay the same. Other scans, added to the list of homes by users, have
/// their own name.
std::string draws_of(const std::string& scan);

/// Writes a graph of one viewpoint under the names that HAMT, DUET and EnvDrop's family use to
/// tabulate the angles of 36 views. These are scan `ZMojNkEp431`, viewpoint
/// `2f4d90acd4024c269fb0efe49a8ac540`. It is not a home of the set, and `scans.txt` does not name
/// it, so that readers of that list skip it.
/// \throws FileError
void write_alias_graph(const OutputFolder& connectivity);

/// Writes annotation files and lists them in `annotations.txt`, one path per line. At the end,
/// files of an earlier run's list that this run does not write are removed, with folders that
/// become empty. So other seeds and fewer tasks leave nothing behind. Files of users in these
/// folders are in no list, and stay.
class WrittenFiles {
 public:
  explicit WrittenFiles(std::filesystem::path folder) : out_(std::move(folder)) {}

  /// OutputFolder::write() of `file`. \throws FileError
  void write(const std::filesystem::path& file, std::string_view text);

  /// Removes old files and writes the list.
  /// \throws FileError, also for a link among the folders of an old file
  /// \throws InvalidInput for a list that names anything that is not below the folder
  void finish();

 private:
  OutputFolder out_;
  std::set<std::string> files_;
};

}  // namespace enfilade::homes::sets
