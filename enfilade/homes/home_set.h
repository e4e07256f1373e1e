/// \file  A data set of model homes: buildings, graphs, panoramas, Room-to-Room.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/capture/scan_files.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/shard.h"
#include "enfilade/homes/plan.h"

namespace enfilade::homes {

/// Which homes are made, and which files of them.
struct HomeSetOptions {
  std::size_t homes = 16;
  std::uint64_t seed = 1;
  std::optional<HomeKind> kind;          ///< none: a mixture, most of them houses
  double least_area = 0, most_area = 0;  ///< m2, drawn between; 0: as usual for the kind
  /// Every so many homes, one is a house or an office of two storeys and 170 m2, whatever the
  /// areas, unless `kind` has no stairs; 0: storeys as usual for kind and area.
  std::size_t stairs_every = 0;
  std::uint32_t face_size = 256;  ///< texels of a panorama's faces; 0: no pictures
  std::uint32_t samples = 4;      ///< colour rays a texel
  int jpeg_quality = 92;

  // What follows is of one run; another may differ in it.
  /// Folder of `<scan>_corrections.json` (graph/corrections.h), applied on top of the graphs, also
  /// of homes that are there already; empty: none, and none stay applied.
  std::filesystem::path corrections;
  /// Matterport3D's files of each home too, below `v1/scans/<scan>`, also of homes that are there.
  capture::ScanParts parts{.connectivity = false};
  std::uint32_t image_width = 1280;  ///< of undistorted images among them, pixels
  Shard shard;
  int threads = 0;  ///< 0: all cores; never changes a byte
};

/// "small": 2 homes, a few viewpoints, for tests; "demo": 16 homes of 25 to 50 viewpoints, three of
/// them of two storeys; "full":
/// 90 homes of 117 viewpoints on average, 512-texel faces; "graphs": 6 homes as of "demo" without
/// pictures, made in a second or two. \throws ArgumentError for another word
HomeSetOptions home_set_preset(std::string_view name);
std::vector<std::string> home_set_presets();

/// A room of a home in a list.
struct RoomEntry {
  char type = '-';  ///< Matterport3D's region letter
  std::string name;
  unsigned storey = 0;
  std::vector<std::string> viewpoints;  ///< ids of those that stand in it
};

/// One home as the folder's list has it.
struct HomeEntry {
  std::string scan;  ///< "home_0001", ...
  PlanOptions plan;  ///< gives make_home() the same home again
  std::string kind;
  std::size_t viewpoints = 0, edges = 0, triangles = 0;
  std::vector<RoomEntry> rooms;  ///< in the order of the plan: a room's place is its region
  std::string corrections;       ///< a checksum of those that its graph has; empty: none
};

/// What write_homes() has done.
struct HomeSetReport {
  std::vector<HomeEntry> homes;   ///< of the shard, in their order
  std::vector<Diagnostic> notes;  ///< warnings: corrections that change nothing
};

/// Told of progress: what is being done, and how much of everything.
using SetProgress =
    std::function<void(const std::string& what, std::size_t done, std::size_t total)>;

/// Makes, or completes, a folder that the rest of Enfilade reads by `--data`: `connectivity/`,
/// `regions/region_to_panorama.json`, `store/<scan>.enfilade` (panoramas, packed), `homes.json`
/// (the list), README.md (that all of it is synthetic). Homes that are there complete, of the same
/// options, are not made again, so that a killed run goes on where it was. The same options and
/// corrections give the same bytes. Paths and instructions come by write_home_paths().
///
/// Runs of different shards may share the folder at the same time; a run of the whole set after
/// them, alone, makes what they left out and the list. \throws FileError if the folder holds
/// something else, or homes of other options (naming the first that differs); ArgumentError for
/// options out of range; NoPlan, naming the home, whose set has to be made with another seed or
/// area; InvalidInput for a broken list or broken corrections. Homes made until then stay
HomeSetReport write_homes(const std::filesystem::path& folder, const HomeSetOptions& options,
                          const SetProgress& progress = {});

/// The list of a folder. \throws FileError, InvalidInput
std::vector<HomeEntry> read_home_list(const std::filesystem::path& folder);

inline constexpr std::size_t kLeastHomes = 3;  ///< that splits by building take

/// How many paths are drawn, and how they are shared out.
struct HomePathOptions {
  std::size_t per_home = 60;  ///< paths at most
  std::uint64_t seed = 1;
  double val_seen_share = 0.15;
  int threads = 0;
};
/// What was written.
struct HomePathReport {
  std::size_t paths = 0, instructions = 0;
};
/// Room-to-Room for a folder of homes: `r2r/R2R_{train,val_seen,val_unseen,test}.json`, three
/// instructions a path, one by each speaker (speaker.h), splits by building in the paper's
/// proportions; whole test paths in `hidden/R2R_test.json`. Graphs are read from the folder, so
/// that corrections made there count. \throws as read_home_list(), graph::GraphSet; FileError if
/// there are fewer than kLeastHomes or the splits cannot be written
HomePathReport write_home_paths(const std::filesystem::path& folder, const HomePathOptions& options,
                                const SetProgress& progress = {});

}  // namespace enfilade::homes
