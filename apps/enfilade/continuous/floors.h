/// \file  Navigation meshes of a data set's buildings.
#pragma once
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "enfilade/agents/continuous_setup.h"

namespace enfilade::apps {

/// Where meshes are, and how they are turned.
struct MeshSource {
  std::string folder;         ///< of `<scan>.glb`, ...; empty: the data set's own places
  std::string up = "format";  ///< as of `scan-mesh`
};

/// A mesh file, and its default up axis.
struct MeshFile {
  std::filesystem::path file;
  std::string up;
};
/// The mesh of a scan in that folder or, without one, in the data set's own places.
std::optional<MeshFile> find_mesh_file(const std::filesystem::path& data, const MeshSource& source,
                                       const std::string& scan);

/// Counts of a data set's buildings.
struct FloorsReport {
  std::size_t made = 0, kept = 0;
  std::vector<std::string> without_mesh;  ///< scans
  std::vector<Diagnostic> faults;         ///< of meshes, a scan each
};

/// Makes the navigation mesh of each scan that has a mesh: a synthetic home's own, made again from
/// its seed, or a file. Existing ones for the same body are kept; a killed run can be continued.
/// \throws FileError
FloorsReport make_floors(const dataset::Dataset& data, const agents::ContinuousSetup& setup,
                         const MeshSource& source, int threads);

}  // namespace enfilade::apps
