// Continuous environments in a model home (SYNTHETIC): steps without pictures, geodesic queries,
// opening a building, memory of one environment more. One thread.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <memory>
#include <vector>

#include "enfilade/continuous/buildings.h"
#include "enfilade/continuous/simulator.h"
#include "enfilade/core/rng.h"
#include "enfilade/homes/built_home.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace {

using continuous::Action;

std::size_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::size_t all = 0, resident = 0;
  statm >> all >> resident;
  return resident * 4096;
}

const mesh::FloorPolygons& floor() {
  static const mesh::FloorPolygons kFloor = [] {
    homes::PlanOptions options;
    options.seed = 5;
    options.area = 260;
    return homes::make_home_floor(homes::build_home(options, homes::HomeSurfaces::kPlain),
                                  continuous::kRoomToRoomBody);
  }();
  return kFloor;
}

std::shared_ptr<const continuous::Buildings> building() {
  static const auto kBuilding =
      std::make_shared<const continuous::Buildings>(std::vector<continuous::Building>{
          {"home", std::make_shared<const continuous::NavigationMesh>(floor())}});
  return kBuilding;
}

// A third each of forward, left and right, at a batch of 64.
void steps(benchmark::State& state) {
  continuous::SimulatorConfig config;
  config.batch_size = 64;
  config.most_steps = 0xffffffffU;
  continuous::Simulator simulator(building(), config);
  Rng rng(1);
  for (std::size_t a = 0; a < 64; ++a) {
    simulator.new_episode(a, {.building = 0,
                              .pose = {building()->floor(0).random_point(rng, 0).point,
                                       Radians(2 * kPi * rng.uniform()),
                                       {}}});
  }
  std::vector<std::vector<Action>> actions(256, std::vector<Action>(64));
  for (auto& list : actions) {
    for (Action& action : list) action = static_cast<Action>(1 + rng.below(3));
  }
  std::size_t k = 0;
  for (auto _ : state) simulator.step(actions[k++ & 255U]);
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * 64);
}
BENCHMARK(steps);

std::vector<continuous::FloorPoint> points() {
  Rng rng(2);
  std::vector<continuous::FloorPoint> drawn;
  for (int k = 0; k < 1024; ++k) drawn.push_back(building()->floor(0).random_point(rng, 0));
  return drawn;
}

// From any point to any other; the median is a counter, as few pairs see each other and many do
// not.
void geodesic_distance(benchmark::State& state) {
  const auto from = points();
  const continuous::Floor& ways = building()->floor(0);
  std::vector<double> micros;
  std::size_t k = 0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(ways.distance(from[k & 1023U], from[(k * 7 + 13) & 1023U]));
    micros.push_back(
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start)
            .count());
    ++k;
  }
  std::ranges::sort(micros);
  state.counters["median_us"] = micros[micros.size() / 2];
  state.counters["p99_us"] = micros[micros.size() * 99 / 100];
}
BENCHMARK(geodesic_distance)->Unit(benchmark::kMicrosecond);

// What a simulator asks at every step: the same goal, another place.
void distance_field(benchmark::State& state) {
  const auto from = points();
  const continuous::DistanceField field = building()->floor(0).field(from[0]);
  std::size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(field.distance(from[k++ & 1023U]));
}
BENCHMARK(distance_field)->Unit(benchmark::kMicrosecond);

// From its file to the first shortest way.
void open_building(benchmark::State& state) {
  const tests::TemporaryFolder folder("bench-walking");
  continuous::save_navigation_mesh(floor(), folder.path() / "home.navmesh");
  for (auto _ : state) {
    const continuous::Buildings opened(folder.path());
    benchmark::DoNotOptimize(opened.floor(0).areas());
  }
}
BENCHMARK(open_building)->Unit(benchmark::kMillisecond);

void make_floor(benchmark::State& state) {
  homes::PlanOptions options;
  options.seed = 5;
  options.area = 260;
  const homes::BuiltHome built = homes::build_home(options, homes::HomeSurfaces::kPlain);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        homes::make_home_floor(built, continuous::kRoomToRoomBody).polygons.size());
  }
}
BENCHMARK(make_floor)->Unit(benchmark::kMillisecond)->Iterations(3);

// Resident memory of 64 environments of one building, each a simulator of its own.
void memory_of_64(benchmark::State& state) {
  for (auto _ : state) {
    const std::size_t before = resident_bytes();
    std::vector<continuous::Simulator> simulators;
    Rng rng(1);
    for (int e = 0; e < 64; ++e) {
      simulators.emplace_back(building(), continuous::SimulatorConfig::room_to_room());
      simulators.back().new_episode(
          0, {.building = 0, .pose = {building()->floor(0).random_point(rng, 0).point, {}, {}}});
      simulators.back().step(std::vector{Action::kForward});
    }
    state.counters["kB_each"] = static_cast<double>(resident_bytes() - before) / 64 / 1024;
  }
}
BENCHMARK(memory_of_64)->Iterations(1);

}  // namespace
}  // namespace enfilade

BENCHMARK_MAIN();
