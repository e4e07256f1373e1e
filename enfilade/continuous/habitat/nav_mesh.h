/// \file  Navigation meshes as Habitat-Sim makes and stores them, byte for byte.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/geometry/vec.h"
#include "enfilade/mesh/mesh.h"

/// Habitat-Sim's navigation: its floor, its bodies, its follower. All points are in Habitat's
/// frame: metres, x right, y up, z towards the viewer. Numbers are float32 and equal to Habitat's,
/// bit for bit. `continuous` above has the exact floor and the exact shortest paths
/// (docs/continuous.md).
namespace enfilade::continuous::habitat {

/// The two states of Habitat-Sim's navigation. They differ in one filter of Recast, and in the
/// place where a body stops at a wall.
enum class Navigation : std::uint8_t {
  kLatest,  ///< since February 2026, after v0.3.3: with Recast 1.6.0
  kV033,    ///< v0.2.0 to v0.3.3, behind the published results of VLN-CE's family
};
constexpr std::array<std::string_view, 2> names_of(Navigation /*enum*/) {
  return {"latest", "0.3.3"};
}

/// Habitat's NavMeshSettings: names, defaults, and the order in files. Lengths in metres.
struct NavMeshSettings {
  float cell_size = 0.05F;
  float cell_height = 0.2F;
  float agent_height = 1.5F;
  float agent_radius = 0.1F;
  float agent_max_climb = 0.2F;
  float agent_max_slope = 45;  ///< degrees
  float region_min_size = 20;  ///< cells on a side
  float region_merge_size = 20;
  float edge_max_len = 12;
  float edge_max_error = 1.3F;  ///< cells
  float verts_per_poly = 6;
  float detail_sample_dist = 6;       ///< cells
  float detail_sample_max_error = 1;  ///< cell heights
  bool filter_low_hanging_obstacles = true;
  bool filter_ledge_spans = true;
  bool filter_walkable_low_height_spans = true;
  bool include_static_objects = false;

  /// As Habitat compares them: numbers that differ by less than 1e-5 are equal.
  friend bool operator==(const NavMeshSettings& a, const NavMeshSettings& b) noexcept;
};

/// How a scene's mesh comes into Habitat's frame.
enum class Upright : std::uint8_t {
  kZ,  ///< every .glb that is opened by its path: +z up in the file, turned by Habitat's own matrix
  kY,  ///< +y up in the file, by a scene dataset with "up": [0, 1, 0], "front": [0, 0, -1]
};
constexpr std::array<std::string_view, 2> names_of(Upright /*enum*/) { return {"z", "y"}; }

/// Triangles in a file's order.
struct Triangles {
  std::vector<Vec3f> corners;
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< indices in corners
};
/// The triangles of a mesh in our world frame, as Habitat has those of its file. Bit-equal if no
/// node of the file is moved. \pre for kZ, the file was read with mesh::UpAxis::kZ
Triangles triangles_of(const mesh::Mesh& mesh, Upright up);

/// A navigation mesh as its file has it. A plain value.
struct NavMesh {
  NavMeshSettings settings;
  Vec3f origin;
  float tile_width = 0, tile_depth = 0;
  std::int32_t most_tiles = 0, most_polygons = 0;
  struct Tile {
    std::uint32_t reference = 0;
    std::vector<std::uint8_t> data;  ///< Detour's, links included
  };
  std::vector<Tile> tiles;
  /// Box around it: of the triangles if it was made from them, of its tiles if it was read.
  Vec3f low, high;
};

/// Makes a navigation mesh by Habitat's recipe. Deterministic.
/// \throws InvalidInput `no-floor`: nothing to stand on; ArgumentError for settings out of range,
/// or cells too small for the mesh
NavMesh make_nav_mesh(const Triangles& triangles, const NavMeshSettings& settings = {},
                      Navigation navigation = Navigation::kLatest);

/// Whether a file that begins so is Habitat's `.navmesh`. \param start  4 bytes at least
bool is_nav_mesh_file(std::string_view start) noexcept;
/// The bytes of Habitat's `.navmesh` file, version 2.
std::string to_nav_mesh_file(const NavMesh& mesh);
/// Reads such a file: version 1 (without settings, so they are the defaults), or 2 (with three or
/// four switches). Tiles are checked, so Detour can use them. \param name  for messages
/// \throws InvalidInput `not-a-nav-mesh`, `other-version`, `truncated`, `damaged`
NavMesh parse_nav_mesh(std::span<const std::uint8_t> bytes, const std::string& name);

}  // namespace enfilade::continuous::habitat
