/// \file  What a benchmark in continuous space needs beside its row in tasks::benchmarks(): a body,
/// a simulator, navigation meshes.
#pragma once
#include <filesystem>
#include <memory>
#include <string_view>

#include "enfilade/continuous/buildings.h"
#include "enfilade/continuous/simulator.h"
#include "enfilade/mesh/walkable.h"
#include "enfilade/tasks/benchmark.h"

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

/// The buildings of a benchmark in a folder of data, opened at first use; null for one on graphs.
/// \throws FileError naming the verb that makes a missing folder; as continuous::Buildings
std::shared_ptr<const continuous::Buildings> open_buildings(const tasks::Benchmark& benchmark,
                                                            const std::filesystem::path& data);

}  // namespace enfilade::agents
