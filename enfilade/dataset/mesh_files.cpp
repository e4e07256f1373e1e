#include "enfilade/dataset/mesh_files.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include "enfilade/core/file.h"

namespace enfilade::dataset {
namespace {

namespace fs = std::filesystem;

std::optional<MeshFile> in_folder(const fs::path& folder, const std::string& scan,
                                  mesh::UpAxis glb_up) {
  for (const char* suffix : {".glb", ".gltf", ".obj", ".ply"}) {
    for (const fs::path& file : {folder / (scan + suffix), folder / scan / (scan + suffix)}) {
      if (file_exists(file)) {
        return MeshFile{file, suffix[1] == 'g' ? glb_up : mesh::UpAxis::kFormat};
      }
    }
  }
  return std::nullopt;
}

// Matterport3D's own OBJ has a name of its own in a folder of that name.
std::optional<MeshFile> of_matterport(const fs::path& data, const std::string& scan) {
  for (const char* scans : {"v1/scans", "scans", "data/v1/scans"}) {
    const fs::path folder = data / scans / scan / "matterport_mesh";
    std::error_code none;
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder, none)) {
      if (entry.path().extension() == ".obj") files.push_back(entry.path());
    }
    if (!files.empty()) return MeshFile{*std::ranges::min_element(files)};
  }
  return std::nullopt;
}

}  // namespace

std::optional<MeshFile> find_mesh_in(const fs::path& folder, const std::string& scan) {
  return in_folder(folder, scan, mesh::UpAxis::kFormat);
}

std::optional<MeshFile> find_mesh_file(const fs::path& data, const std::string& scan) {
  for (const char* folder : {"mp3d", "scene_datasets/mp3d", "data/scene_datasets/mp3d"}) {
    if (auto found = in_folder(data / folder, scan, mesh::UpAxis::kZ)) return found;
  }
  if (auto found = of_matterport(data, scan)) return found;
  return find_mesh_in(data / "meshes", scan);
}

}  // namespace enfilade::dataset
