#include "enfilade/agents/continuous_benchmark.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

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

fs::path ContinuousBenchmark::navigation_folder() const { return fs::path("navmesh") / name; }

tasks::ContinuousResultsForm ContinuousBenchmark::results_form() const noexcept {
  return form == tasks::ContinuousForm::kRxr ? tasks::ContinuousResultsForm::kRxr
                                             : tasks::ContinuousResultsForm::kR2r;
}

const std::vector<ContinuousBenchmark>& continuous_benchmarks() {
  using continuous::SimulatorConfig;
  static const std::vector<ContinuousBenchmark> kAll{
      {"r2r-ce", "R2R-CE", tasks::ContinuousForm::kR2r, tasks::Task::kR2r,
       continuous::kRoomToRoomBody, SimulatorConfig::room_to_room()},
      {"rxr-ce", "RxR-CE", tasks::ContinuousForm::kRxr, tasks::Task::kRxr,
       continuous::kRoomAcrossRoomBody, SimulatorConfig::room_across_room()}};
  return kAll;
}

bool is_continuous(std::string_view name) noexcept {
  return std::ranges::any_of(continuous_benchmarks(),
                             [&](const ContinuousBenchmark& b) { return b.name == name; });
}

const ContinuousBenchmark& continuous_benchmark(std::string_view name) {
  const auto& all = continuous_benchmarks();
  const auto found = std::ranges::find(all, name, &ContinuousBenchmark::name);
  if (found != all.end()) return *found;
  std::vector<std::string_view> names;
  for (const ContinuousBenchmark& b : all) names.push_back(b.name);
  throw LookupError(fmt::format("no benchmark \"{}\" of walking freely; there are {}", name,
                                fmt::join(names, ", ")));
}

std::optional<fs::path> find_continuous_split(const ContinuousBenchmark& benchmark,
                                              const fs::path& data, const std::string& split) {
  return first_there(data, tasks::continuous_places(benchmark.form, split));
}

tasks::ContinuousEpisodes load_continuous_split(const ContinuousBenchmark& benchmark,
                                                const fs::path& data, const std::string& split) {
  if (const auto file = find_continuous_split(benchmark, data, split)) {
    return tasks::load_continuous_episodes(*file, split);
  }
  std::vector<std::string> tried;
  for (const fs::path& place : tasks::continuous_places(benchmark.form, split)) {
    tried.push_back((data / place).string());
  }
  throw FileError(
      fmt::format("no episodes of {} {}: tried {}; `enfilade continuous {}` makes them "
                  "of Room-to-Room's",
                  benchmark.name, split, fmt::join(tried, ", "), data.string()));
}

tasks::ExpertWalks load_experts_of(const ContinuousBenchmark& benchmark, const fs::path& data,
                                   const std::string& split) {
  const auto file = first_there(data, tasks::expert_places(benchmark.form, split));
  return file ? tasks::load_expert_walks(*file) : tasks::ExpertWalks();
}

}  // namespace enfilade::agents
