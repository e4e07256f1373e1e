#include "enfilade/continuous/pixels/surfaces.h"

#include <cmath>

namespace enfilade::continuous::pixels {
namespace {

using mesh::Mesh;

struct Corners {
  std::array<std::size_t, 3> of;  ///< the mesh's corners, by ours
  Vec3d origin, u, v;             ///< corner 0, and the edges to the others
};

Corners corners_of(const Mesh& mesh, std::size_t triangle) {
  std::array<Vec3d, 3> at;
  for (std::size_t k = 0; k < 3; ++k) {
    at[k] = to_double(mesh.positions[mesh.triangles[triangle][k]]);
  }
  std::size_t first = 0;
  double longest = -1;
  for (std::size_t k = 0; k < 3; ++k) {
    const double opposite = length(at[(k + 2) % 3] - at[(k + 1) % 3]);
    if (opposite <= longest) continue;
    longest = opposite;
    first = k;
  }
  const std::array<std::size_t, 3> of{first, (first + 1) % 3, (first + 2) % 3};
  return {of, at[of[0]], at[of[1]] - at[of[0]], at[of[2]] - at[of[0]]};
}

Surface surface_of(const Mesh& mesh, std::size_t triangle) {
  const Corners c = corners_of(mesh, triangle);
  Surface s;
  s.origin = to_float(c.origin);
  s.first_corner = static_cast<std::uint8_t>(c.of[0]);
  const Vec3d normal = cross(c.u, c.v);
  const double square = dot(normal, normal);
  s.normal = {0, 0, 1};
  if (square > 0) {
    s.normal = to_float(1 / std::sqrt(square) * normal);
    s.along_u = to_float(1 / square * cross(c.v, normal));
    s.along_v = to_float(1 / square * cross(normal, c.u));
  }
  s.paint = mesh.triangle_material[triangle];
  if (const std::uint32_t object = mesh::object_of(mesh, triangle); object != mesh::kNoObject) {
    s.category = mesh.objects[object].category;
    s.instance = object + 1;
  }
  if (!mesh.texture_points.empty()) {
    const auto& points = mesh.texture_points[triangle];
    const auto &a = points[c.of[0]], &b = points[c.of[1]], &d = points[c.of[2]];
    // Whole repetitions are taken off, which keeps the digits for what is left.
    s.s0 = a.u - std::floor(a.u);
    s.t0 = a.v - std::floor(a.v);
    s.su = b.u - a.u;
    s.tu = b.v - a.v;
    s.sv = d.u - a.u;
    s.tv = d.v - a.v;
  }
  return s;
}

// The square root of the triangle's area in texels over that in space.
float texels_per_metre(const Surface& s, float width, float height) {
  const Vec3f across = cross(s.along_u, s.along_v);  // its length: 1 / twice the area
  return std::sqrt(std::abs(s.su * s.tv - s.sv * s.tu) * width * height * length(across));
}

}  // namespace

Surfaces::Surfaces(const Mesh& mesh, float least_mirror)
    : light{pack_light({}), pack_light({1, 1, 1})} {
  for (const mesh::Material& material : mesh.materials) {
    Paint paint;
    paint.colour = (1 - material.mirror) * material.colour;
    paint.emission = material.emission;
    if (material.mirror < least_mirror) {
      constexpr float kAround = 0.5F;  // about what a room reflects
      paint.gloss = kAround * material.mirror;
    } else {
      paint.mirror = material.mirror;
    }
    if (!material.texture.pixels.empty() && !mesh.texture_points.empty()) {
      paint.texture = textures.add(material.texture);
      if (material.texture.channels == 4) paint.cutout = material.cutout;
    }
    paints.push_back(paint);
  }
  all.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Surface s = surface_of(mesh, t);
    if (const std::uint32_t texture = paints[s.paint].texture; texture != Paint::kNoTexture) {
      s.texels_per_metre = texels_per_metre(s, textures.width(texture), textures.height(texture));
    }
    s.front = s.back = kWhite;
    if (!mesh.colours.empty()) {
      const auto colour = [&](unsigned k) {
        return mesh.colours[mesh.triangles[t][(s.first_corner + k) % 3U]];
      };
      const Vec3f a = colour(0), b = colour(1), c = colour(2);
      s.front = s.back = static_cast<std::uint32_t>(light.size());
      s.cells_u = s.cells_v = 1;
      // The fourth value continues the triangle's plane.
      for (const Vec3f x : {a, b, c, b + c - a}) light.push_back(pack_light(x));
    }
    all.push_back(s);
  }
}

}  // namespace enfilade::continuous::pixels
