/// \file  Reader and writer of `<scan>_connectivity.json`, Matterport3D's navigation graphs.
#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/ids.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::scan {

/// One entry of a connectivity file: a viewpoint.
struct ConnectivityEntry {
  std::string id;                 ///< viewpoint id (`image_id`); 32 hex digits in Matterport3D
  std::array<double, 16> pose{};  ///< camera to world, 4 x 4 row-major, metres
  bool included = true;           ///< false: not part of the simulator
  double height = 0;              ///< above the floor, metres; 0 if the file has none
  std::vector<ViewpointIndex> unobstructed;  ///< indices of the entries that are true, ascending
  std::vector<ViewpointIndex> visible;       ///< likewise

  Vec3d position() const { return {pose[3], pose[7], pose[11]}; }  ///< world frame
};

/// A whole file. Entries keep their order: an entry's index is its ViewpointIndex.
struct Connectivity {
  std::string scan;  ///< scan id, from the file's name
  std::string file;  ///< where it was read, for messages
  std::vector<ConnectivityEntry> entries;
};

/// Whether a text may be a scan id: is_id() (core/names.h). So an id is safe in file names, command
/// lines and URLs. Examples: `17DRP5sb8fy` (Matterport3D), `00000-kfPV7w3FaU5` (HM3D).
bool is_scan_id(std::string_view scan);
/// \throws LookupError naming `scan` if it is not a scan id
void require_scan_id(std::string_view scan);

/// What HM3D's files of a scan are named: "TEEsavR23oF" for "00800-TEEsavR23oF", which is five
/// digits, a hyphen and the name. A part of `scan`; empty for other ids.
std::string_view name_in_hm3d(std::string_view scan) noexcept;

/// Reads `<directory>/<scan>_connectivity.json`, packed or not (find_text_file()).
/// \throws FileError if it cannot be read
/// \throws InvalidInput listing its faults (up to 1000) with their JSON paths:
/// - not JSON; a missing, repeated or wrongly typed field
/// - a pose that isn't 16 numbers; `unobstructed` or `visible` of another length than the file
/// - numbers beyond kMostMetres (core/numbers.h)
/// - an invalid id (`bad-id`, core/names.h), or one that is there twice
Connectivity load_connectivity(const std::filesystem::path& directory, std::string_view scan);

/// The same for a file of any name. \throws FileError; InvalidInput
Connectivity load_connectivity_file(const std::filesystem::path& file, std::string scan);

/// The same for a text in memory; `file` is its name in messages. \throws InvalidInput
Connectivity parse_connectivity(std::string_view json, std::string scan, const std::string& file);

/// The file's content in Matterport3D's format, which load_connectivity() reads back equal.
std::string to_json(const Connectivity& connectivity);

/// Writes `<directory>/<scan>_connectivity.json` and adds the scan to the folder's `scans.txt`, if
/// it is not there. Creates the folder. A blank list is replaced; another one is kept as UTF-8
/// without a byte-order mark.
/// \throws FileError; InvalidInput if the list repeats an id or holds one that is no scan id: then
/// nothing is written
void save_connectivity(const std::filesystem::path& directory, const Connectivity& connectivity);
/// The same, in a folder whose links are not followed.
void save_connectivity(const OutputFolder& directory, const Connectivity& connectivity);

/// Throws what save_connectivity() would because of `scans.txt`. For callers that write other files
/// first. \throws FileError; InvalidInput
void check_scan_list(const std::filesystem::path& directory);

/// The scans of a connectivity folder: the ids in its `scans.txt` (white space between), in order.
/// They may end with `_connectivity.json`. Lines of any system, a byte-order mark and lines that
/// begin with # are accepted.
/// \throws FileError; InvalidInput if the list is blank, repeats an id, or holds one that is no
/// scan id
std::vector<std::string> load_scan_list(const std::filesystem::path& directory);

/// `<directory>/<scan>_connectivity.json`.
std::filesystem::path connectivity_file(const std::filesystem::path& directory,
                                        std::string_view scan);
/// That file, or else the packed one (`.json.gz`); no value: neither is there.
std::optional<std::filesystem::path> find_connectivity(const std::filesystem::path& directory,
                                                       std::string_view scan);
/// The scan that a connectivity file, packed or not, is named after; no value for other names.
std::optional<std::string> scan_of_file(const std::filesystem::path& file);

}  // namespace enfilade::scan
