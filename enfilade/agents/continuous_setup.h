/// \file  What a benchmark in continuous space needs beside its row in tasks::benchmarks(): a body,
/// a simulator, navigation meshes.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/continuous/simulator.h"
#include "enfilade/mesh/walkable.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_results.h"

namespace enfilade::agents {

/// Of one benchmark.
struct ContinuousSetup {
  const tasks::Benchmark* benchmark = nullptr;
  mesh::Body body;
  continuous::SimulatorConfig simulator;

  /// The folder of its navigation meshes in a data set: "navmesh/r2r-ce".
  std::filesystem::path navigation_folder() const;
};

/// \pre benchmark.continuous()
const ContinuousSetup& continuous_setup(const tasks::Benchmark& benchmark);
/// By the benchmark's name. \throws LookupError listing those in continuous space
const ContinuousSetup& continuous_setup(std::string_view name);

/// A split's file in a folder of data, by tasks::episode_places(); none if it has none.
std::optional<std::filesystem::path> find_continuous_split(const tasks::Benchmark& benchmark,
                                                           const std::filesystem::path& data,
                                                           const std::string& split);
/// A split's episodes in a folder of data, and its experts' walks where there are any.
/// \throws FileError naming every place that was tried; InvalidInput
tasks::ContinuousEpisodes load_continuous_split(const tasks::Benchmark& benchmark,
                                                const std::filesystem::path& data,
                                                const std::string& split);
tasks::ExpertWalks load_experts_of(const tasks::Benchmark& benchmark,
                                   const std::filesystem::path& data, const std::string& split);

}  // namespace enfilade::agents
