/// \file  Shared by the verbs that take a mesh: its options, its id as a scan, its floor.
#pragma once
#include <string>

#include "apps/common/program.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::apps {

struct MeshOptions {
  std::string file, scan, up = "format";
  double scale = 1;  ///< metres per unit of the file
};
/// MESH, --scan, --scale, --up
void add_mesh_options(CLI::App& verb, MeshOptions& options);

/// --scan; without it, the id from the mesh's file name or that of `graph`, a connectivity file
/// that may be "".
/// \throws UsageError if --scan cannot be part of a file name
std::string scan_of(const MeshOptions& options, const std::string& graph = "");

/// Reads the file and prints its warnings. \throws as mesh::read_mesh()
mesh::Mesh read_mesh_file(const MeshOptions& options);

/// \throws as mesh::WalkableFloor, faults naming the file
mesh::WalkableFloor find_floor(const mesh::Mesh& mesh, const MeshOptions& options,
                               const mesh::WalkableOptions& walk = {});

}  // namespace enfilade::apps
