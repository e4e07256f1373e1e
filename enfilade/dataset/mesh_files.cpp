#include "enfilade/dataset/mesh_files.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <vector>

#include "enfilade/core/file.h"

namespace enfilade::dataset {
namespace {

namespace fs = std::filesystem;

// Those of HM3D; the folders below have the buildings.
constexpr std::array<const char*, 4> kSplits{"train", "val", "minival", "test"};

// What HM3D's files are called in the folder "00800-TEEsavR23oF": "TEEsavR23oF". Empty for ids of
// another form.
std::string_view name_in_hm3d(std::string_view scan) {
  const std::size_t digits = scan.find_first_not_of("0123456789");
  const bool numbered = digits != 0 && digits != std::string_view::npos && scan[digits] == '-';
  return numbered ? scan.substr(digits + 1) : std::string_view();
}

std::optional<MeshFile> in_folder(const fs::path& folder, const std::string& scan,
                                  mesh::UpAxis glb_up) {
  for (const char* suffix : {".glb", ".gltf", ".obj", ".ply", ".basis.glb"}) {
    for (const fs::path& file : {folder / (scan + suffix), folder / scan / (scan + suffix)}) {
      if (file_exists(file)) {
        return MeshFile{file, file.extension().string()[1] == 'g' ? glb_up : mesh::UpAxis::kFormat};
      }
    }
  }
  return std::nullopt;
}

// Files of HM3D. Where a building has both, the one whose textures are plain pictures.
std::optional<MeshFile> in_hm3d(const fs::path& folder, const std::string& scan) {
  const std::string name(name_in_hm3d(scan));
  if (name.empty()) return std::nullopt;
  const auto in = [&](const fs::path& split) -> std::optional<MeshFile> {
    for (const char* suffix : {".glb", ".basis.glb"}) {
      const fs::path file = split / scan / (name + suffix);
      if (file_exists(file)) return MeshFile{file, mesh::UpAxis::kZ};
    }
    return std::nullopt;
  };
  if (auto found = in(folder)) return found;
  for (const char* split : kSplits) {
    if (auto found = in(folder / split)) return found;
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
  if (auto found = in_folder(folder, scan, mesh::UpAxis::kFormat)) return found;
  return in_hm3d(folder, scan);
}

std::optional<MeshFile> find_mesh_file(const fs::path& data, const std::string& scan) {
  for (const char* above : {"", "scene_datasets", "data/scene_datasets"}) {
    if (auto found = in_folder(data / above / "mp3d", scan, mesh::UpAxis::kZ)) return found;
    for (const char* folder : {"hm3d", "hm3d_v0.2", "hm3d_v0.1"}) {
      if (auto found = in_hm3d(data / above / folder, scan)) return found;
    }
  }
  if (auto found = in_hm3d(data / "data/versioned_data/hm3d-0.2/hm3d", scan)) return found;
  if (auto found = of_matterport(data, scan)) return found;
  return find_mesh_in(data / "meshes", scan);
}

}  // namespace enfilade::dataset
