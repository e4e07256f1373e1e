#include "enfilade/agents/continuous_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <system_error>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"

namespace enfilade::agents {

namespace fs = std::filesystem;

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
  return continuous_setup(tasks::benchmark(name, tasks::WorldKind::kContinuous));
}

std::shared_ptr<const continuous::Buildings> open_buildings(const tasks::Benchmark& benchmark,
                                                            const fs::path& data) {
  if (!benchmark.continuous()) return nullptr;
  const fs::path folder = data / continuous_setup(benchmark).navigation_folder();
  std::error_code unknown;  // Buildings reports what else is wrong with it
  if (!fs::exists(folder, unknown) && !unknown) {
    throw FileError(
        fmt::format("{}: no such folder of navigation meshes; `enfilade continuous {}` makes it",
                    folder.string(), data.string()));
  }
  return std::make_shared<const continuous::Buildings>(folder);
}

}  // namespace enfilade::agents
