/// \file  R2R-CE and RxR-CE by name: body, simulator settings, file locations.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/continuous/simulator.h"
#include "enfilade/mesh/walkable.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/goal.h"

namespace enfilade::agents {

/// One of them.
struct ContinuousBenchmark {
  std::string_view name;  ///< "r2r-ce"
  std::string_view title;
  tasks::ContinuousForm form = tasks::ContinuousForm::kR2r;
  tasks::Task paths = tasks::Task::kR2r;  ///< benchmark on graphs, whose paths its episodes follow
  mesh::Body body;
  continuous::SimulatorConfig simulator;

  /// The folder of its navigation meshes in a data set: "navmesh/r2r-ce".
  std::filesystem::path navigation_folder() const;
  /// In which its results are written.
  tasks::ContinuousResultsForm results_form() const noexcept;
};

/// All: R2R-CE (VLN-CE) and RxR-CE.
const std::vector<ContinuousBenchmark>& continuous_benchmarks();
bool is_continuous(std::string_view name) noexcept;
/// \throws LookupError listing the names
const ContinuousBenchmark& continuous_benchmark(std::string_view name);

/// A split's file in a folder of data, by tasks::continuous_places(); none if it has none.
std::optional<std::filesystem::path> find_continuous_split(const ContinuousBenchmark& benchmark,
                                                           const std::filesystem::path& data,
                                                           const std::string& split);
/// A split's episodes in a folder of data, and its experts' trajectories if there are any.
/// \throws FileError naming every file that was tried; InvalidInput
tasks::ContinuousEpisodes load_continuous_split(const ContinuousBenchmark& benchmark,
                                                const std::filesystem::path& data,
                                                const std::string& split);
tasks::ExpertWalks load_experts_of(const ContinuousBenchmark& benchmark,
                                   const std::filesystem::path& data, const std::string& split);

}  // namespace enfilade::agents
