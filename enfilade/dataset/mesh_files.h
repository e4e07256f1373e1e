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

/// The mesh of a scan in a data set's usual folders; no value if there is none. Below the data,
/// `scene_datasets/` and `data/scene_datasets/`:
/// - `mp3d/SCAN/SCAN.glb` as Habitat has Matterport3D
/// - `hm3d/{train,val,minival,test}/00800-NAME/NAME.glb` or `NAME.basis.glb` of the scan
///   `00800-NAME`, as Habitat has HM3D; also `hm3d_v0.2/`, without the splits' folders, and where
///   Habitat's download puts it (`data/versioned_data/hm3d-0.2/hm3d/`)
///
/// Both have z up against glTF's convention. Then `v1/scans/SCAN/matterport_mesh/*/*.obj` as
/// Matterport3D's, and `meshes/`.
std::optional<MeshFile> find_mesh_file(const std::filesystem::path& data, const std::string& scan);

/// The same in one folder: `<scan>.glb`, .gltf, .obj, .ply or .basis.glb, there or in a folder of
/// that name. Else as HM3D's (z up), there or in the folder of a split. The folder may be that of
/// the scan itself.
std::optional<MeshFile> find_mesh_in(const std::filesystem::path& folder, const std::string& scan);

/// The mesh that a path names: the file, or that of a scan's folder as find_mesh_in() finds it.
/// HM3D's `00800-NAME/NAME.glb` and `NAME.basis.glb` have z up. `path` itself for other folders.
MeshFile mesh_at(const std::filesystem::path& path);

}  // namespace enfilade::dataset
