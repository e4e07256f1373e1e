// Continuous navigation in model homes, whose floors are known exactly. SYNTHETIC.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/mesh_floor.h"
#include "enfilade/agents/run.h"
#include "enfilade/continuous/geodesics.h"
#include "enfilade/continuous/simulator.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/tasks/files.h"
#include "tests/continuous/box_ways.h"
#include "tests/support/small_homes.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

using namespace continuous;

homes::BuiltHome flat(std::uint64_t seed) {
  return homes::build_home(
      {.seed = seed, .kind = homes::HomeKind::kFlat, .storeys = {}, .area = 90},
      homes::HomeSurfaces::kPlain);
}

std::shared_ptr<const NavigationMesh> floor_of(const homes::BuiltHome& home) {
  return std::make_shared<const NavigationMesh>(homes::make_home_floor(home, kRoomToRoomBody));
}

PlanPoint seen_from_above(const FloorPoint& p) { return {p.point.x, p.point.y}; }

// Boxes are what the generator places; the mesh has rounded edges here and there, so single ways
// differ by more than the rim's error.
TEST(ContinuousHomes, GeodesicsAreThoseOfAVisibilityGraph) {
  std::vector<double> errors;
  std::size_t one_way = 0;
  for (std::uint64_t seed = 9001; seed <= 9006; ++seed) {
    const homes::BuiltHome home = flat(seed);
    const Geodesics ways(floor_of(home));
    const BoxWays truth(home.home, 0, kRoomToRoomBody);
    Rng rng(seed);
    for (int pairs = 0; pairs < 75;) {
      const FloorPoint a = ways.mesh().random_point(rng, 0), b = ways.mesh().random_point(rng, 0);
      const PlanPoint from = seen_from_above(a), to = seen_from_above(b);
      if (!truth.is_free(from) || !truth.is_free(to)) continue;  // within the rim's error
      ++pairs;
      const double found = ways.distance(a, b), expected = truth.distance(from, to);
      if (std::isinf(found) != std::isinf(expected)) ++one_way;
      if (std::isfinite(found) && std::isfinite(expected))
        errors.push_back(std::abs(found - expected));
    }
  }
  std::ranges::sort(errors);
  EXPECT_LT(errors[errors.size() / 2], 0.01);
  EXPECT_LT(errors[errors.size() * 99 / 100], 0.05);
  EXPECT_LE(one_way, errors.size() / 100);  // a gap as wide as the body, to a cell
  RecordProperty("median_mm", static_cast<int>(1000 * errors[errors.size() / 2]));
}

// Rays around the body find nothing nearer than its radius, less the rim's error.
TEST(ContinuousHomes, NoStepEndsInAWall) {
  const homes::BuiltHome home = flat(9001);
  const auto buildings =
      std::make_shared<const Buildings>(std::vector<Building>{{"home9001", floor_of(home)}});
  SimulatorConfig config = SimulatorConfig::room_to_room();
  config.batch_size = 500;
  config.most_steps = 1'000'000;
  Simulator simulator(buildings, config);
  Rng rng(1);
  std::vector<EpisodeStart> starts;
  for (std::size_t a = 0; a < config.batch_size; ++a) {
    starts.push_back({.building = 0,
                      .pose = {buildings->floor(0).random_point(rng, 0).point,
                               Radians(2 * kPi * rng.uniform()),
                               {}}});
  }
  simulator.new_episodes(starts);
  constexpr std::size_t kRays = 6;
  constexpr float kFree = 0.1F - 0.055F;  // the radius, less a cell, the rim's error, a round edge
  std::vector<Action> actions(config.batch_size);
  std::vector<mesh::Ray> rays(config.batch_size * kRays);
  std::vector<std::uint8_t> blocked(rays.size());
  std::size_t in_walls = 0;
  for (int step = 0; step < 2000; ++step) {
    for (Action& action : actions) action = static_cast<Action>(1 + rng.below(3));
    simulator.step(actions);
    for (std::size_t a = 0; a < config.batch_size; ++a) {
      const Vec3f feet = simulator.state().position[a];
      const auto height = static_cast<float>(0.25 + 1.2 * rng.uniform());
      for (std::size_t r = 0; r < kRays; ++r) {
        const double angle = 2 * kPi * (static_cast<double>(r) + rng.uniform()) / kRays;
        rays[a * kRays + r] = {.origin = feet + Vec3f{0, 0, height},
                               .direction = to_float(Vec3d{std::sin(angle), std::cos(angle), 0}),
                               .near = 0,
                               .far = kFree};
      }
    }
    home.tracer->blocked(rays, blocked);
    in_walls += static_cast<std::size_t>(std::ranges::count(blocked, 1));
  }
  EXPECT_EQ(in_walls, 0U);
}

// From the graph's annotations to walks that are scored.
TEST(ContinuousHomes, ExpertsReachTheirGoals) {
  const TemporaryFolder folder("continuous-homes");
  write_small_homes(folder.path(), 4);
  std::vector<Building> made;
  for (const homes::HomeEntry& entry : homes::read_home_list(folder.path())) {
    made.push_back(
        {entry.scan, floor_of(homes::build_home(entry.plan, homes::HomeSurfaces::kPlain))});
  }
  const auto buildings = std::make_shared<const Buildings>(std::move(made));
  const agents::MeshFloor floor(buildings);
  const dataset::Dataset data(folder.path());
  std::size_t paths = 0, dropped = 0, walks = 0, successes = 0, by_reference = 0;
  double ndtw = 0;
  for (const char* split : {"train", "val_seen", "val_unseen"}) {
    const tasks::Annotations annotations = data.annotations(split);
    const tasks::DerivedEpisodes derived =
        tasks::derive_continuous(annotations, *data.graphs(), floor);
    paths += annotations.paths.size();
    dropped += derived.dropped.size();
    const tasks::ContinuousEpisodes& episodes = derived.episodes;
    const tasks::ExpertWalks experts = agents::record_experts(episodes, buildings);
    ASSERT_EQ(experts.size(), episodes.episodes.size());
    for (const std::string name : {"shortest", "reference"}) {
      const auto agent = agents::make_continuous_agent(name);
      const auto results = agents::run_continuous(*agent, episodes, buildings);
      for (const tasks::ContinuousScore& score :
           agents::score_continuous_walks(results, episodes, *buildings, experts)) {
        if (name == "shortest") {
          ++walks;
          successes += score.success > 0 ? 1 : 0;
        } else {
          by_reference += score.success > 0 ? 1 : 0;
          ndtw += score.ndtw;
        }
      }
    }
  }
  ASSERT_GT(walks, 250U);
  EXPECT_LE(dropped, paths / 20);  // edges of the graph are 0.4 m wide and free
  EXPECT_GE(static_cast<double>(successes), 0.99 * static_cast<double>(walks));
  EXPECT_GE(static_cast<double>(by_reference), 0.98 * static_cast<double>(walks));
  EXPECT_GT(ndtw / static_cast<double>(walks), 0.999);  // it is what nDTW compares with
}

// A graph agent decides, a controller walks: Shortest of the graph arrives in either world.
TEST(ContinuousHomes, GraphAgentsWalkTheirTrajectories) {
  const TemporaryFolder folder("continuous-graph");
  write_small_homes(folder.path(), 3);
  std::vector<Building> made;
  for (const homes::HomeEntry& entry : homes::read_home_list(folder.path())) {
    made.push_back(
        {entry.scan, floor_of(homes::build_home(entry.plan, homes::HomeSurfaces::kPlain))});
  }
  const auto buildings = std::make_shared<const Buildings>(std::move(made));
  const agents::MeshFloor floor(buildings);
  const dataset::Dataset data(folder.path());
  const tasks::EpisodeSet set = data.episodes("val_seen", tasks::Instructions::kAll);
  const tasks::DerivedEpisodes derived =
      tasks::derive_continuous(data.annotations("val_seen"), *data.graphs(), floor);
  const auto in_graph = agents::make_agent("shortest");
  std::vector<tasks::Trajectory> trajectories = agents::run_agent(*in_graph, set);
  const auto walker =
      agents::make_graph_walker("shortest", trajectories, set, derived.episodes, floor);
  const auto walks = agents::run_continuous(*walker, derived.episodes, buildings);
  std::size_t successes = 0;
  for (const tasks::ContinuousScore& score :
       agents::score_continuous_walks(walks, derived.episodes, *buildings)) {
    successes += score.success > 0 ? 1 : 0;
  }
  ASSERT_GT(walks.size(), 10U);
  EXPECT_GE(static_cast<double>(successes), 0.98 * static_cast<double>(walks.size()));
  trajectories.pop_back();
  EXPECT_THROW(agents::make_graph_walker("shortest", trajectories, set, derived.episodes, floor),
               ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
