/// \file  Names of the homes of a set, and a graph under a name that other code needs. Internal.
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace enfilade::homes::sets {

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
void write_alias_graph(const std::filesystem::path& connectivity);

}  // namespace enfilade::homes::sets
