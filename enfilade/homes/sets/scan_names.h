/// \file  Names of the homes of a set, and a graph under a name that other code asks for. Internal.
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
/// What the ids of viewpoints, paths and headings of a home are drawn from: the name that it had in
/// the first versions, so that they stay the same. Of other scans, which somebody wrote into the
/// list of homes, their own name.
std::string draws_of(const std::string& scan);

/// Writes a graph of one viewpoint under the names that HAMT, DUET and EnvDrop's family ask their
/// simulator for, to tabulate the angles of 36 views: scan `ZMojNkEp431`, viewpoint
/// `2f4d90acd4024c269fb0efe49a8ac540`. It is no home of the set: `scans.txt` does not name it, so
/// that whoever goes by that list does not see it. \throws FileError
void write_alias_graph(const std::filesystem::path& connectivity);

}  // namespace enfilade::homes::sets
