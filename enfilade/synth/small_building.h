/// \file  A small made-up building with a graph, rooms and R2R annotations: what runs where no real
/// data is. Synthetic, and says so; model homes with meshes and pictures come later (docs/synth.md).
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/r2r/annotations.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::synth {

/// A region (room) and the viewpoints in it.
struct Room {
  std::string name;  ///< "kitchen"
  std::vector<ViewpointIndex> viewpoints;
};

struct SmallBuilding {
  scan::Connectivity connectivity;
  std::vector<Room> rooms;
};

/// Two storeys of rooms along corridors, joined by stairs, doors between neighbours; about 40
/// viewpoints 1.5 to 3 m apart, edges up to 5 m that keep to doors; connected. The same seed gives
/// the same building on every platform.
SmallBuilding make_small_building(std::uint64_t seed, const std::string& scan);

/// Writes a whole data set that the rest of Enfilade reads like R2R's (DataRoot's first layout):
/// `connectivity/`, `regions/region_to_panorama.json`, `r2r/R2R_{train,val_seen,val_unseen,test}.json`
/// with three plain instructions a path made from the turns and rooms along it, and a README that
/// says that it is synthetic.
/// \throws FileError
void write_small_dataset(const std::filesystem::path& folder, std::size_t buildings = 6,
                         std::uint64_t seed = 1);

}  // namespace enfilade::synth
