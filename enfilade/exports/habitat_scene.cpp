#include "enfilade/exports/habitat_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <span>
#include <system_error>
#include <type_traits>
#include <vector>

#include "enfilade/continuous/simulator.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/image/tone.h"
#include "enfilade/mesh/house.h"
#include "enfilade/mesh/read_mesh.h"

namespace enfilade::exports {
namespace {

constexpr std::int32_t kMostObject = 65535;
constexpr std::string_view kScenesFolder = "scene_datasets/mp3d";

// Where the labels lie: z up, as the .house file and Matterport3D's own. Habitat turns a .ply with
// z up by itself, after it has turned it as the scene dataset says: there, by nothing (y up).
Vec3f semantic_point(Vec3f world) { return world; }

static_assert(std::endian::native == std::endian::little, "the PLY file is little-endian");

template <class T>
void put_number(std::string& out, T value) {
  static_assert(std::is_arithmetic_v<T>);
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

bool is_content(const std::filesystem::path& file, std::string_view content) {
  std::error_code code;  // ignored: the size of a missing file is 2^64 - 1, unlike any content's
  return std::filesystem::file_size(file, code) == content.size() && read_file(file) == content;
}

}  // namespace

std::string habitat_scene_file(std::string_view scan, std::string_view ending) {
  return fmt::format("{0}/{1}/{1}{2}", kScenesFolder, scan, ending);
}

std::string to_semantic_ply(const mesh::LabelledMesh& labels) {
  const mesh::Mesh& mesh = labels.mesh;
  EN_CHECK_EQ(labels.face_object.size(), mesh.triangles.size());
  for (const std::int32_t object : labels.face_object) {
    if (object > kMostObject) {
      throw ArgumentError(fmt::format("object {}: Habitat's labels have 16 bits, so {} is the last",
                                      object, kMostObject));
    }
  }
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nelement face {}\nproperty list uchar int vertex_indices\n"
      "property int object_id\nend_header\n",
      mesh.positions.size(), mesh.triangles.size());
  out.reserve(out.size() + 15 * mesh.positions.size() + 17 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3f p = semantic_point(mesh.positions[i]);
    const Vec3f c = mesh.colours.empty() ? Vec3f{1, 1, 1} : mesh.colours[i];
    for (const float metres : {p.x, p.y, p.z}) put_number(out, metres);
    for (const float share : {c.x, c.y, c.z}) put_number(out, image::srgb8_from_linear(share));
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    put_number(out, std::uint8_t{3});
    for (const std::uint32_t corner : mesh.triangles[t]) put_number(out, corner);
    put_number(out, std::max(labels.face_object[t], 0));  // -1 would be 65535 to Habitat
  }
  return out;
}

continuous::HabitatSceneFloor write_habitat_scene(const OutputFolder& data, const std::string& scan,
                                                  const mesh::Mesh& building,
                                                  const capture::HouseFiles& house) {
  const auto name = [&](std::string_view ending) { return habitat_scene_file(scan, ending); };
  const std::string glb = mesh::to_glb(building, mesh::UpAxis::kZ);
  const std::filesystem::path there = data.path() / name(".navmesh");
  const bool keep = is_content(data.path() / name(".glb"), glb) && file_exists(there);
  if (!keep) data.remove(name(".navmesh"));  // of another .glb
  data.write(name(".glb"), glb);
  data.write(name(".house"), to_text(house.house));
  data.write(name("_semantic.ply"), to_semantic_ply(house.labels));
  if (keep) {
    const std::string bytes = read_file(there);
    return continuous::HabitatSceneFloor::of_file(
        std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()),
        there.string());
  }
  // Made of the file's triangles, in their order, as Habitat does.
  continuous::HabitatSceneFloor floor = continuous::HabitatSceneFloor::of_mesh(
      mesh::parse_mesh(glb, scan + ".glb", {.up = mesh::UpAxis::kZ}).mesh, mesh::UpAxis::kZ,
      continuous::kRoomToRoomBody);
  data.write(name(".navmesh"), floor.file());
  return floor;
}

void write_habitat_dataset(const OutputFolder& data) {
  // As by path, +z is up and +y in front. Habitat puts each scene's own path for the long word.
  data.write(std::string(kScenesFolder) + "/mp3d.scene_dataset_config.json", R"({
  "stages": {
    "default_attributes": {
      "up": [0, 0, 1],
      "front": [0, 1, 0],
      "semantic_up": [0, 1, 0],
      "semantic_front": [0, 0, -1],
      "nav_asset": "%%CONFIG_NAME_AS_ASSET_FILENAME%%.navmesh",
      "semantic_asset": "%%CONFIG_NAME_AS_ASSET_FILENAME%%_semantic.ply",
      "semantic_descriptor_filename": "%%CONFIG_NAME_AS_ASSET_FILENAME%%.house"
    },
    "paths": {".glb": ["*/*.glb"]}
  }
}
)");
}

}  // namespace enfilade::exports
