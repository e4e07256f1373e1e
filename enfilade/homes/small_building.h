/// \file  A small made-up building with a graph, rooms and R2R annotations: what runs where no real
/// data is. Synthetic, and says so; model homes with meshes and pictures come later
/// (docs/homes.md).
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::homes {

/// A region (room) and the viewpoints in it.
struct Room {
  std::string name;  ///< "kitchen"; no two of a building are alike
  std::vector<ViewpointIndex> viewpoints;
};

/// A building without pictures: a graph, and the rooms that its viewpoints are in.
struct SmallBuilding {
  scan::Connectivity connectivity;
  std::vector<Room> rooms;  ///< each viewpoint is in one
};

/// Two storeys of rooms along a hallway, joined by stairs, a door to each room; about 45 viewpoints
/// 1.5 to 3 m apart, 1.5 m above the floor, edges up to 5 m that keep to doors; connected.
/// `visible` is what walls let through on a storey, and the edges. The same seed gives the same
/// building on every platform; `scan` is only its name.
SmallBuilding make_small_building(std::uint64_t seed, const std::string& scan);

/// Writes a whole data set that the rest of Enfilade reads like R2R's (DataRoot's first layout):
/// `connectivity/` of scans "synth_1", ..., `regions/region_to_panorama.json`,
/// `r2r/R2R_{train,val_seen,val_unseen,test}.json` (30 paths a building) with three plain
/// instructions a path made from the turns and rooms along it, and a README that says that it is
/// synthetic. The same arguments give the same bytes.
/// \throws ArgumentError for fewer than 3 buildings (train, val_unseen and test need one each) or
/// more than 1000; FileError if it cannot be written, or the folder holds something else: only a
/// new or empty folder, or an earlier data set of this kind, is written to
void write_small_dataset(const std::filesystem::path& folder, std::size_t buildings = 6,
                         std::uint64_t seed = 1);

}  // namespace enfilade::homes
