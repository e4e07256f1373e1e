// Habitat's .navmesh files, and the way of their tiles into Detour and back.
#include <DetourAlloc.h>
#include <DetourCommon.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "enfilade/continuous/habitat/detour.h"
#include "enfilade/continuous/habitat/settings_table.h"
#include "enfilade/core/errors.h"

namespace enfilade::continuous::habitat {
namespace {

static_assert(std::endian::native == std::endian::little, "files are written as memory is");

constexpr std::int32_t kMagic = 0x4D534554;  // 'MSET'
constexpr std::int32_t kVersion = 2;
constexpr unsigned short kWithoutArea = 4;  // the flag of polygons that nothing can stand on
constexpr float kLeastArea = 1e-5F;         // m2, doubled
constexpr float kFarthest = 1e6F;           // metres
constexpr float kLeastTile = 0.01F;         // metres
constexpr unsigned int kSides = 0b010101;   // of a triangle's flags: edges that are the polygon's
constexpr std::int32_t kMostTiles = 1 << 12, kMostPolygons = 1 << 20;

// Not a number is far, too. Detour squares distances in float32.
bool is_near(const std::array<float, 3>& point) {
  return std::ranges::all_of(point, [](float v) { return std::abs(v) <= kFarthest; });
}

[[noreturn]] void refuse(const std::string& name, const char* code, std::string message) {
  throw InvalidInput({{Severity::kError, name, "", code, std::move(message)}});
}

class Reader {
 public:
  Reader(std::span<const std::uint8_t> bytes, const std::string& name)
      : left_(bytes), name_(name) {}

  std::span<const std::uint8_t> take(std::size_t n, const char* what) {
    if (left_.size() < n) {
      refuse(name_, "truncated",
             fmt::format("it ends within {}: {} bytes of {}", what, left_.size(), n));
    }
    const auto out = left_.first(n);
    left_ = left_.subspan(n);
    return out;
  }
  template <class T>
  T number(const char* what) {
    static_assert(std::is_trivially_copyable_v<T>);
    T out;
    std::memcpy(&out, take(sizeof out, what).data(), sizeof out);
    return out;
  }

 private:
  std::span<const std::uint8_t> left_;
  const std::string& name_;
};

template <class T>
void put(std::string& out, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  out.append(bytes.data(), bytes.size());
}

// A tile's lists, as Detour lays them out. It trusts all of their numbers, so they are checked.
class TileCheck {
 public:
  TileCheck(const std::vector<std::uint8_t>& data, std::int32_t most_polygons,
            const std::string& name)
      : name_(name) {
    if (data.size() < sizeof header_) fail("a tile has no head");
    std::memcpy(&header_, data.data(), sizeof header_);
    if (header_.magic != DT_NAVMESH_MAGIC || header_.version != DT_NAVMESH_VERSION) {
      fail(fmt::format("a tile of version {}, not {}", header_.version, DT_NAVMESH_VERSION));
    }
    if (header_.polyCount < 1 || header_.polyCount > most_polygons) {
      fail(fmt::format("a tile of {} polygons, not 1 to {}", header_.polyCount, most_polygons));
    }
    if (header_.offMeshConCount != 0 || header_.offMeshBase != header_.polyCount) {
      fail("a tile with connections off the mesh, which Habitat does not make");
    }
    if (header_.maxLinkCount < 1) fail("a tile without links");
    std::size_t at = dtAlign4(sizeof header_);
    const auto list = [&]<class T>(std::vector<T>& out, int count) {
      if (count < 0 || static_cast<std::size_t>(count) > data.size() / sizeof(T) ||
          data.size() - at < static_cast<std::size_t>(count) * sizeof(T)) {
        fail("a tile that is shorter than its lists");
      }
      out.resize(static_cast<std::size_t>(count));
      if (count > 0) std::memcpy(out.data(), data.data() + at, out.size() * sizeof(T));
      at += static_cast<std::size_t>(dtAlign4(static_cast<int>(out.size() * sizeof(T))));
    };
    std::vector<std::array<float, 3>> corners, points;
    std::vector<dtPoly> polygons;
    std::vector<dtLink> links;
    std::vector<dtPolyDetail> details;
    std::vector<std::array<unsigned char, 4>> triangles;
    std::vector<dtBVNode> nodes;
    list(corners, header_.vertCount);
    list(polygons, header_.polyCount);
    list(links, header_.maxLinkCount);
    list(details, header_.detailMeshCount);
    list(points, header_.detailVertCount);
    list(triangles, header_.detailTriCount);
    list(nodes, header_.bvNodeCount);
    if (at > data.size()) fail("a tile that is shorter than its lists");
    check_points(corners);
    check_points(points);
    if (details.size() != polygons.size()) fail("a tile without heights for each polygon");
    for (std::size_t p = 0; p < polygons.size(); ++p) check_polygon(polygons[p]);
    for (std::size_t p = 0; p < polygons.size(); ++p) {
      check_heights(details[p], polygons[p], points.size(), triangles);
    }
    for (std::size_t n = 0; n < nodes.size(); ++n) check_node(nodes[n], nodes.size() - n);
    if (!(header_.bvQuantFactor > 0) || !std::isfinite(header_.bvQuantFactor)) {
      fail(fmt::format("a tile with cells of {} to the metre", header_.bvQuantFactor));
    }
  }

 private:
  [[noreturn]] void fail(std::string message) const {
    refuse(name_, "damaged", std::move(message));
  }

  void check_points(const std::vector<std::array<float, 3>>& points) const {
    for (const auto& point : points) {
      if (!is_near(point)) fail(fmt::format("a corner farther than {} m", kFarthest));
    }
  }
  void check_polygon(const dtPoly& polygon) const {
    if (polygon.vertCount < 3 || polygon.vertCount > DT_VERTS_PER_POLYGON ||
        polygon.getType() != DT_POLYTYPE_GROUND) {
      fail(fmt::format("a polygon of {} corners, not 3 to {}", polygon.vertCount,
                       DT_VERTS_PER_POLYGON));
    }
    for (int k = 0; k < polygon.vertCount; ++k) {
      if (polygon.verts[k] >= header_.vertCount) {
        fail(fmt::format("corner {} of {}", polygon.verts[k], header_.vertCount));
      }
      const bool outside = (polygon.neis[k] & DT_EXT_LINK) != 0;
      if (!outside && polygon.neis[k] > header_.polyCount) {
        fail(fmt::format("neighbour {} of {}", polygon.neis[k], header_.polyCount));
      }
    }
  }
  void check_heights(const dtPolyDetail& detail, const dtPoly& polygon, std::size_t points,
                     const std::vector<std::array<unsigned char, 4>>& triangles) const {
    if (std::size_t{detail.vertBase} + detail.vertCount > points ||
        std::size_t{detail.triBase} + detail.triCount > triangles.size()) {
      fail("heights of a polygon that are not there");
    }
    unsigned int sides = 0;
    for (std::size_t t = 0; t < detail.triCount; ++t) {
      const auto& triangle = triangles[detail.triBase + t];
      for (std::size_t k = 0; k < 3; ++k) {
        if (triangle[k] >= polygon.vertCount + detail.vertCount) {
          fail("a triangle with a corner that is not there");
        }
      }
      sides |= triangle[3] & kSides;
    }
    // Detour looks for the nearest of them.
    if (sides == 0 && (polygon.flags & kWalkable) != 0) fail("a polygon without sides");
  }
  // A node's number is its polygon, or how many nodes to leave out if the box is elsewhere.
  void check_node(const dtBVNode& node, std::size_t left) const {
    if (node.i >= 0 ? node.i >= header_.polyCount : std::size_t(-std::int64_t{node.i}) > left) {
      fail("a box of something that is not there");
    }
  }

  dtMeshHeader header_{};
  const std::string& name_;
};

// Numbers of the whole, by which Detour finds tiles.
void check_lattice(const NavMesh& mesh, const std::string& name) {
  if (!is_near(array_of(mesh.origin))) {
    refuse(name, "damaged", fmt::format("an origin farther than {} m", kFarthest));
  }
  for (const float side : {mesh.tile_width, mesh.tile_depth}) {
    if (!(side >= kLeastTile && side <= 2 * kFarthest)) {
      refuse(name, "damaged",
             fmt::format("tiles of {} m, not {} to {}", side, kLeastTile, 2 * kFarthest));
    }
  }
}

float doubled_area(const dtMeshTile& tile, const dtPoly& polygon) {
  float sum = 0;
  for (int k = 2; k < polygon.vertCount; ++k) {
    sum += dtTriArea2D(tile.verts + 3 * polygon.verts[0], tile.verts + 3 * polygon.verts[k - 1],
                       tile.verts + 3 * polygon.verts[k]);
  }
  return std::abs(sum);
}

void close_polygons_without_area(const dtNavMesh& mesh) {
  for (int t = 0; t < mesh.getMaxTiles(); ++t) {
    const dtMeshTile* tile = mesh.getTile(t);
    if (tile->header == nullptr) continue;
    for (int p = 0; p < tile->header->polyCount; ++p) {
      dtPoly& polygon = tile->polys[p];
      if (doubled_area(*tile, polygon) < kLeastArea) polygon.flags = kWithoutArea;
    }
  }
}

}  // namespace

std::unique_ptr<dtNavMesh> open_in_detour(const NavMesh& mesh, const std::string& name) {
  dtNavMeshParams params{};
  std::ranges::copy(array_of(mesh.origin), params.orig);
  params.tileWidth = mesh.tile_width;
  params.tileHeight = mesh.tile_depth;
  params.maxTiles = mesh.most_tiles;
  params.maxPolys = mesh.most_polygons;
  auto out = std::make_unique<dtNavMesh>();
  if (dtStatusFailed(out->init(&params))) {
    refuse(name, "damaged",
           fmt::format("{} tiles of {} polygons are too many for Detour", mesh.most_tiles,
                       mesh.most_polygons));
  }
  for (const NavMesh::Tile& tile : mesh.tiles) {
    auto* data = static_cast<unsigned char*>(dtAlloc(tile.data.size(), DT_ALLOC_PERM));
    if (data == nullptr) throw Error("navigation mesh: out of memory");
    std::ranges::copy(tile.data, data);
    if (dtStatusFailed(out->addTile(data, static_cast<int>(tile.data.size()), DT_TILE_FREE_DATA,
                                    tile.reference, nullptr))) {
      dtFree(data);
      refuse(name, "damaged", fmt::format("tile {} does not fit the others", tile.reference));
    }
  }
  close_polygons_without_area(*out);
  return out;
}

void take_from_detour(const dtNavMesh& mesh, NavMesh& out) {
  close_polygons_without_area(mesh);
  const dtNavMeshParams& params = *mesh.getParams();
  out.origin = point_of(params.orig);
  out.tile_width = params.tileWidth;
  out.tile_depth = params.tileHeight;
  out.most_tiles = params.maxTiles;
  out.most_polygons = params.maxPolys;
  out.tiles.clear();
  for (int t = 0; t < mesh.getMaxTiles(); ++t) {
    const dtMeshTile* tile = mesh.getTile(t);
    if (tile->header == nullptr) continue;
    out.tiles.push_back({mesh.getTileRef(tile), {tile->data, tile->data + tile->dataSize}});
  }
}

std::string to_nav_mesh_file(const NavMesh& mesh) {
  std::string out;
  put(out, kMagic);
  put(out, kVersion);
  put(out, static_cast<std::int32_t>(mesh.tiles.size()));
  put(out, array_of(mesh.origin));
  put(out, mesh.tile_width);
  put(out, mesh.tile_depth);
  put(out, mesh.most_tiles);
  put(out, mesh.most_polygons);
  for (const NumberSetting& number : kNumberSettings) put(out, mesh.settings.*number.value);
  for (const SwitchSetting& one : kSwitchSettings) put(out, mesh.settings.*one.value);
  for (const NavMesh::Tile& tile : mesh.tiles) {
    put(out, tile.reference);
    put(out, static_cast<std::int32_t>(tile.data.size()));
    out.append(reinterpret_cast<const char*>(tile.data.data()), tile.data.size());
  }
  return out;
}

bool is_nav_mesh_file(std::string_view start) noexcept {
  std::int32_t magic = 0;
  if (start.size() < sizeof magic) return false;
  std::memcpy(&magic, start.data(), sizeof magic);
  return magic == kMagic;
}

NavMesh parse_nav_mesh(std::span<const std::uint8_t> bytes, const std::string& name) {
  Reader in(bytes, name);
  if (in.number<std::int32_t>("its head") != kMagic) {
    refuse(name, "not-a-nav-mesh", "it does not begin as Habitat's .navmesh files do");
  }
  const auto version = in.number<std::int32_t>("its head");
  if (version != 1 && version != kVersion) {
    refuse(name, "other-version", fmt::format("version {}, not 1 or {}", version, kVersion));
  }
  const auto tiles = in.number<std::int32_t>("its head");
  NavMesh out;
  out.origin = point_of(in.number<std::array<float, 3>>("its head").data());
  out.tile_width = in.number<float>("its head");
  out.tile_depth = in.number<float>("its head");
  out.most_tiles = in.number<std::int32_t>("its head");
  out.most_polygons = in.number<std::int32_t>("its head");
  if (tiles < 1 || tiles > out.most_tiles || out.most_tiles > kMostTiles) {
    refuse(name, "damaged",
           fmt::format("{} of {} tiles, not 1 to {}", tiles, out.most_tiles, kMostTiles));
  }
  if (out.most_polygons < 1 || out.most_polygons > kMostPolygons) {
    refuse(name, "damaged",
           fmt::format("{} polygons a tile, not 1 to {}", out.most_polygons, kMostPolygons));
  }
  check_lattice(out, name);
  if (version == kVersion) {
    for (const NumberSetting& number : kNumberSettings) {
      out.settings.*number.value = in.number<float>("its settings");
    }
    for (const SwitchSetting& one : kSwitchSettings) {
      // Before v0.3.0 the last one was padding: any byte.
      out.settings.*one.value = in.number<std::uint8_t>("its settings") == 1;
    }
  }
  constexpr float kFar = std::numeric_limits<float>::max();
  out.low = {kFar, kFar, kFar};
  out.high = {-kFar, -kFar, -kFar};
  for (std::int32_t t = 0; t < tiles; ++t) {
    NavMesh::Tile& tile = out.tiles.emplace_back();
    tile.reference = in.number<std::uint32_t>("a tile's head");
    const auto size = in.number<std::int32_t>("a tile's head");
    if (size < 0) refuse(name, "damaged", fmt::format("a tile of {} bytes", size));
    const auto data = in.take(static_cast<std::size_t>(size), "a tile");
    tile.data.assign(data.begin(), data.end());
    const TileCheck check(tile.data, out.most_polygons, name);
    dtMeshHeader header;
    std::memcpy(&header, tile.data.data(), sizeof header);
    out.low = {std::min(out.low.x, header.bmin[0]), std::min(out.low.y, header.bmin[1]),
               std::min(out.low.z, header.bmin[2])};
    out.high = {std::max(out.high.x, header.bmax[0]), std::max(out.high.y, header.bmax[1]),
                std::max(out.high.z, header.bmax[2])};
  }
  take_from_detour(*open_in_detour(out, name), out);
  return out;
}

}  // namespace enfilade::continuous::habitat
