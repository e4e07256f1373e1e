/// \file  A room of 6 by 4 m for sessions in continuous space, and episodes in it. SYNTHETIC.
#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/arena/world.h"
#include "tests/support/made_meshes.h"

namespace enfilade::arena::testing {

/// The mesh of the scan "room".
inline std::shared_ptr<const mesh::RayTracer> room_tracer() {
  return std::make_shared<const mesh::RayTracer>(
      std::make_shared<const mesh::Mesh>(mesh::testing::Maker().room(0, 0, 6, 4).mesh));
}

/// Episode 5, "Walk east." from (1, 1) looking east, to (5, 1); with `more`, others from other
/// places of the room to (5, 3). A split of that benchmark.
inline FloorWorld room(std::int64_t more = 0, std::string_view task = "r2r-ce") {
  auto all = std::make_shared<tasks::ContinuousEpisodes>();
  all->split = "test";
  for (std::int64_t k = 0; k <= more; ++k) {
    tasks::ContinuousEpisode& one = all->episodes.emplace_back();
    one.id = 5 + k;
    one.trajectory_id = 50 + k;
    one.scene = "mp3d/room/room.glb";
    one.start = {1 + 0.3 * static_cast<double>(k), 1, 0};
    one.rotation = tasks::StartRotation::of(degrees(90 + 50.0 * static_cast<double>(k)));
    one.instruction.text = k == 0 ? "Walk east." : "Walk to corner " + std::to_string(k) + ".";
    one.goals = {{.position = {5, k == 0 ? 1.0 : 3.0, 0}, .radius = 3}};
    one.reference_path = {one.start, one.goals->front().position};
  }
  return {tasks::Split(tasks::benchmark(task), std::move(all)),
          std::make_shared<const continuous::Buildings>(std::vector<continuous::Building>{
              {"room", std::make_shared<const continuous::NavigationMesh>(
                           mesh::make_floor_polygons(*room_tracer()))}})};
}

}  // namespace enfilade::arena::testing
