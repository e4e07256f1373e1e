#include "enfilade/capture/plain_room.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/image/textures.h"
#include "enfilade/mesh/mesh_builder.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::capture {
namespace {

constexpr double kStanding = .3;     // metres above the lowest point of all
constexpr double kRoomMargin = 1.5;  // metres from the objects to the walls
constexpr double kRoomHeight = 3;    // metres
using enum mesh::Mpcat40::Category;

double floor_height(const mesh::Mesh& mesh) {
  // Lowest point of each object, and of what belongs to none.
  std::vector<double> lowest(mesh.objects.size() + 1, HUGE_VAL);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t object = object_of(mesh, t);
    double& low = object == mesh::kNoObject ? lowest.back() : lowest[object];
    for (const std::uint32_t v : mesh.triangles[t]) {
      low = std::min(low, static_cast<double>(mesh.positions[v].z));
    }
  }
  std::ranges::sort(lowest);
  std::size_t standing = 0;
  while (standing < lowest.size() && lowest[standing] <= lowest[0] + kStanding) ++standing;
  return lowest[standing / 2];
}

mesh::Material textured(const image::Texture& texture, const char* name) {
  mesh::Material material;
  material.name = name;
  material.colour = {1, 1, 1};
  material.texture = texture();
  return material;
}

}  // namespace

void add_plain_room(mesh::Mesh& mesh) {
  const mesh::Box box = mesh::bounds(mesh);
  const double x0 = box.low.x - kRoomMargin, x1 = box.high.x + kRoomMargin,
               y0 = box.low.y - kRoomMargin, y1 = box.high.y + kRoomMargin, z0 = floor_height(mesh),
               z1 = std::max(z0 + kRoomHeight, box.high.z + .3);  // nothing sticks out
  mesh::Mesh room;
  mesh::MeshBuilder b(room);
  Rng rng(1, stream_of("plain room", 10));
  const auto planks =
      b.add_material(textured(image::planks(rng, {.50, .37, .25}, 8), "plain room: planks"), 1.6);
  const auto plaster =
      b.add_material(textured(image::plaster(rng, {.88, .85, .78}), "plain room: plaster"), 2);
  const Vec3d a{x0, y0, z0}, c{x1, y0, z0}, e{x1, y1, z0}, g{x0, y1, z0};
  const auto above = [&](Vec3d p) { return Vec3d{p.x, p.y, z1}; };
  b.begin_object("floor", kFloor, -1);
  b.quad(planks, a, c, e, g);
  b.begin_object("ceiling", kCeiling, -1);
  b.quad(plaster, above(a), above(g), above(e), above(c));
  const auto wall = [&](Vec3d from, Vec3d to) {
    b.begin_object("wall", kWall, -1);
    b.quad(plaster, from, to, above(to), above(from));  // faces inwards
  };
  wall(c, a);
  wall(a, g);
  wall(g, e);
  wall(e, c);
  append(mesh, room);
}

double share_of_nothing_below(const mesh::RayTracer& tracer, const scan::Connectivity& graph) {
  constexpr int kAround = 16;
  std::size_t rays = 0, empty = 0;
  for (const scan::ConnectivityEntry& entry : graph.entries) {
    if (!entry.included) continue;
    const Vec3f eye = to_float(entry.position());
    for (int k = 0; k < kAround; ++k, ++rays) {
      const double angle = 2 * std::numbers::pi * k / kAround;
      empty += !tracer.trace(
          {eye, {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), -.5F}});
    }
  }
  return rays == 0 ? 0 : static_cast<double>(empty) / static_cast<double>(rays);
}

}  // namespace enfilade::capture
