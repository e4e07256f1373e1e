/// \file  Meshes of verbs: the mesh of an option and its floor. Meshes and scenes of a data set's
/// buildings.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "apps/common/program.h"
#include "enfilade/continuous/scene.h"
#include "enfilade/dataset/mesh_files.h"
#include "enfilade/exports/expert_walks.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::apps {

/// The axis that --up names.
mesh::UpAxis up_axis(const std::string& name);

struct MeshOptions {
  std::string file, scan, up = "format";
  double scale = 1;  ///< metres per unit of the file

  mesh::ReadOptions read() const { return {scale, up_axis(up)}; }
};
/// MESH, --scan, --scale, --up
void add_mesh_options(CLI::App& verb, MeshOptions& options);

/// --scan; without it, the id from the mesh's file name or that of `graph`, a connectivity file
/// that may be "".
/// \throws UsageError if --scan cannot be part of a file name
std::string scan_of(const MeshOptions& options, const std::string& graph = "");

/// Reads the mesh that dataset::mesh_at() finds, and prints its warnings. Its axis counts where
/// `options` leave that to the format. \throws as mesh::read_mesh()
mesh::Mesh read_mesh_file(const std::filesystem::path& file, const mesh::ReadOptions& options);

/// \throws as mesh::WalkableFloor, faults naming the file
mesh::WalkableFloor find_floor(const mesh::Mesh& mesh, const MeshOptions& options,
                               const mesh::WalkableOptions& walk = {});

/// Where meshes are, and how they are turned.
struct MeshSource {
  std::string folder = {};    ///< of `<scan>.glb`, ...; empty: the data set's own places
  std::string up = "format";  ///< as of `scan-mesh`
};
/// The mesh of a scan in that folder or, without one, in the data set's own places.
std::optional<dataset::MeshFile> find_mesh_file(const std::filesystem::path& data,
                                                const MeshSource& source, const std::string& scan);

/// Result of make_home_lights().
struct LightsReport {
  std::size_t made = 0, kept = 0;
};
/// Computes the light of all synthetic homes of a data set, and stores it, with their meshes as
/// viewers show them (homes/lit_home.h). Existing files stay.
/// \throws FileError; InvalidInput for light of another home
LightsReport make_home_lights(const dataset::Dataset& data, int threads);

/// The scene of a synthetic home or of the scan's mesh file. A home is made again with its
/// textures, and with its stored light, or light that is made now. A mesh file is photographed or
/// lit.
/// \throws UsageError for a scan without a mesh; as Scene::open()
std::shared_ptr<const continuous::Scene> scene_of_scan(const dataset::Dataset& data,
                                                       const MeshSource& source,
                                                       const std::string& scan, int threads);

/// The same with the scan's panoramas, if `appearance` requires them.
/// \throws UsageError if the scan has none; as scene_of_scan()
exports::BuildingLook look_of_scan(const dataset::Dataset& data, const MeshSource& source,
                                   const std::string& scan, continuous::Appearance appearance,
                                   int threads);

/// --appearance, "mesh" or "panoramas"
void add_appearance_option(CLI::App& verb, std::string& appearance);

}  // namespace enfilade::apps
