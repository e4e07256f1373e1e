#include "enfilade/dataset/mesh_files.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::dataset {
namespace {

namespace fs = std::filesystem;

// Those of HM3D; the folders below have the buildings.
constexpr std::array<const char*, 4> kSplits{"train", "val", "minival", "test"};
// Endings of its meshes. The first counts where a building has both: its textures are plain.
constexpr std::array<const char*, 2> kHm3dEndings{".glb", ".basis.glb"};

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

// With all folders, and none of its own behind a last "/".
fs::path whole(const fs::path& path) {
  std::error_code none;
  const fs::path all = fs::absolute(path, none).lexically_normal();
  return all.has_filename() ? all : all.parent_path();
}

// Files of HM3D.
std::optional<MeshFile> in_hm3d(const fs::path& folder, const std::string& scan) {
  const std::string name(scan::name_in_hm3d(scan));
  if (name.empty()) return std::nullopt;
  const auto in = [&](const fs::path& split) -> std::optional<MeshFile> {
    for (const char* ending : kHm3dEndings) {
      const fs::path file = split / scan / (name + ending);
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
    for (fs::recursive_directory_iterator entry(folder, none), end; !none && entry != end;
         entry.increment(none)) {
      if (entry->path().extension() == ".obj") files.push_back(entry->path());
    }
    if (!files.empty()) return MeshFile{*std::ranges::min_element(files)};
  }
  return std::nullopt;
}

}  // namespace

std::optional<MeshFile> find_mesh_in(const fs::path& folder, const std::string& scan) {
  std::vector<fs::path> folders{folder};
  if (const fs::path own = whole(folder); own.filename() == scan) {  // that of this scan alone
    folders.push_back(own.parent_path());
  }
  for (const fs::path& one : folders) {
    if (auto found = in_folder(one, scan, mesh::UpAxis::kFormat)) return found;
    if (auto found = in_hm3d(one, scan)) return found;
  }
  return std::nullopt;
}

MeshFile mesh_at(const fs::path& path) {
  const fs::path named = whole(path), above = named.parent_path();
  std::error_code none;
  if (fs::is_directory(named, none)) {
    return find_mesh_in(above, named.filename().string()).value_or(MeshFile{path});
  }
  const std::string name(scan::name_in_hm3d(above.filename().string()));
  const bool hm3d = !name.empty() && std::ranges::any_of(kHm3dEndings, [&](const char* ending) {
    return named.filename() == name + ending;
  });
  return {path, hm3d ? mesh::UpAxis::kZ : mesh::UpAxis::kFormat};
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
