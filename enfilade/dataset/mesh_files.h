/// \file  Where the meshes of a data set's buildings are.
#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "enfilade/mesh/read_mesh.h"

namespace enfilade::dataset {

/// A mesh file, and which axis of it points up.
struct MeshFile {
  std::filesystem::path file;
  mesh::UpAxis up = mesh::UpAxis::kFormat;
};

/// The mesh of a scan in a data set's usual folders; no value if there is none.
/// `mp3d/SCAN/SCAN.glb` as Habitat's (also below `scene_datasets/` and `data/`, z up against glTF's
/// convention), `v1/scans/SCAN/matterport_mesh/*/*.obj` as Matterport3D's, and `meshes/`.
std::optional<MeshFile> find_mesh_file(const std::filesystem::path& data, const std::string& scan);

/// The same in one folder: `<scan>.glb`, .gltf, .obj or .ply, there or in a folder of that name.
std::optional<MeshFile> find_mesh_in(const std::filesystem::path& folder, const std::string& scan);

}  // namespace enfilade::dataset
