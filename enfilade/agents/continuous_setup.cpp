#include "enfilade/agents/continuous_setup.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"

namespace enfilade::agents {

namespace {

namespace fs = std::filesystem;

std::optional<fs::path> first_there(const fs::path& data, const std::vector<fs::path>& places) {
  for (const fs::path& place : places) {
    if (file_exists(data / place)) return data / place;
  }
  return std::nullopt;
}

}  // namespace

fs::path ContinuousSetup::navigation_folder() const {
  return fs::path("navmesh") / benchmark->name;
}

const ContinuousSetup& continuous_setup(const tasks::Benchmark& benchmark) {
  using continuous::SimulatorConfig;
  static const std::array<ContinuousSetup, 2> kAll{
      {{&tasks::benchmark("r2r-ce"), continuous::kRoomToRoomBody, SimulatorConfig::room_to_room()},
       {&tasks::benchmark("rxr-ce"), continuous::kRoomAcrossRoomBody,
        SimulatorConfig::room_across_room()}}};
  const auto* found = std::ranges::find(kAll, &benchmark, &ContinuousSetup::benchmark);
  EN_CHECK(found != kAll.end());
  return *found;
}

const ContinuousSetup& continuous_setup(std::string_view name) {
  return continuous_setup(tasks::benchmark(name, tasks::World::kContinuous));
}

std::optional<fs::path> find_continuous_split(const tasks::Benchmark& benchmark,
                                              const fs::path& data, const std::string& split) {
  return first_there(data, tasks::episode_places(benchmark, split));
}

tasks::ContinuousEpisodes load_continuous_split(const tasks::Benchmark& benchmark,
                                                const fs::path& data, const std::string& split) {
  if (const auto file = find_continuous_split(benchmark, data, split)) {
    return tasks::load_continuous_episodes(*file, split);
  }
  std::vector<std::string> tried;
  for (const fs::path& place : tasks::episode_places(benchmark, split)) {
    tried.push_back((data / place).string());
  }
  throw FileError(
      fmt::format("no episodes of {} {}: tried {}; `enfilade continuous {}` makes them "
                  "of Room-to-Room's",
                  benchmark.name, split, fmt::join(tried, ", "), data.string()));
}

tasks::ExpertWalks load_experts_of(const tasks::Benchmark& benchmark, const fs::path& data,
                                   const std::string& split) {
  const auto file = first_there(data, tasks::expert_places(benchmark, split));
  return file ? tasks::load_expert_walks(*file) : tasks::ExpertWalks();
}

}  // namespace enfilade::agents
