/// \file  What a data set tells of a building's rooms, walls and furniture, for every drawing of
/// it.
#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/draw/plan_underlay.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::homes {

/// A room as plans show it.
struct PlannedRoom {
  std::string name;                        ///< may be empty
  std::size_t storey = 0;                  ///< place in draw::find_storeys() of the graph
  double floor = 0;                        ///< z, metres, world frame
  double height = 0;                       ///< metres; 0: unknown
  std::vector<Vec3f> outline;              ///< its corners in order; metres, world frame
  std::vector<ViewpointIndex> viewpoints;  ///< those in it, of the graph
};

/// Rooms and lines of a building.
struct BuildingPlan {
  std::vector<PlannedRoom> rooms;
  /// Walls, doors, windows, stairs and furniture of each of draw::find_storeys(), with the names of
  /// rooms. No lines where nothing tells of them.
  draw::PlanUnderlay underlay;

  /// For draw::FloorPlanOptions; null without lines. It lives as long as this does.
  const draw::PlanUnderlay* drawn() const noexcept;
};

/// Reads the plan of a graph's building. A synthetic home's is in the list of its folder; it is
/// completed() if the list lacks the lines of these storeys. A scanned building's is in
/// `SCAN/house_segmentations/SCAN.house`: regions are walls, objects are boxes. There is no plan of
/// other buildings.
/// \param data the data set's folder  \param images folders with the scans' files
/// \throws FileError, InvalidInput for a broken file; as completed()
BuildingPlan read_building_plan(const std::filesystem::path& data,
                                std::span<const std::filesystem::path> images,
                                const graph::NavGraph& graph);

}  // namespace enfilade::homes
