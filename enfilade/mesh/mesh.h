/// \file  Triangle meshes with materials and labels, and cross-sections of them.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/image/image.h"

namespace enfilade::mesh {

/// Texture coordinates: (0, 0) is the top left corner of the picture (not a pixel's centre), u to
/// the right, v down. The texture repeats outside [0, 1].
struct TexturePoint {
  float u = 0, v = 0;
};

/// Appearance of a surface, the same on both sides.
struct Material {
  std::string name;
  Vec3f colour{0.8F, 0.8F, 0.8F};  ///< linear reflectance in [0, 1]; multiplies the texture
  Vec3f emission;                  ///< emitted linear radiance; >= 0
  float mirror = 0;                ///< share of specular reflection, [0, 1]
  image::Image8 texture;           ///< sRGB, 3 channels, or 4 with cut-outs; empty: none
  float cutout = 0;                ///< alpha test: no surface where alpha is below; [0, 1]; 0: none
  std::string texture_file;        ///< file of the texture; empty: generated, or none
};

/// A labelled object: one instance in pictures.
struct Object {
  std::string name;            ///< raw label such as "coffee table"
  std::uint16_t category = 0;  ///< index of mpcat40; 0: void
  std::int32_t region = -1;    ///< index of its room; -1: none
};

/// The object of triangles that belong to none.
inline constexpr std::uint32_t kNoObject = std::numeric_limits<std::uint32_t>::max();

/// A mesh. World frame: metres, +z up, right-handed. Optional lists are empty or have one entry for
/// each element of the list that they describe. A plain value.
struct Mesh {
  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices in positions
  std::vector<std::uint32_t> triangle_material;         ///< index in materials, one a triangle
  std::vector<std::uint32_t> triangle_object;  ///< index in objects, or kNoObject; optional
  std::vector<std::array<TexturePoint, 3>> texture_points;  ///< of each corner; optional
  std::vector<std::array<Vec3f, 3>> normals;  ///< of each corner, length 1, for shading; optional
  std::vector<Vec3f> colours;                 ///< linear, of each position; optional; multiplies
  std::vector<Material> materials;
  std::vector<Object> objects;  ///< object k is instance k + 1 in pictures; 0 there: none
};

/// The object that a triangle belongs to, or kNoObject. \pre triangle < mesh.triangles.size()
inline std::uint32_t object_of(const Mesh& mesh, std::size_t triangle) {
  return mesh.triangle_object.empty() ? kNoObject : mesh.triangle_object[triangle];
}

/// Tells which triangles belong to no room, such as lawns. In a mesh without rooms none does.
class Surroundings {
 public:
  /// \pre mesh outlives this
  explicit Surroundings(const Mesh& mesh)
      : mesh_(mesh), has_rooms_(std::ranges::any_of(mesh.objects, [](const Object& object) {
          return object.region >= 0;
        })) {}
  /// \pre triangle < mesh.triangles.size()
  bool has(std::size_t triangle) const {
    if (!has_rooms_) return false;
    const std::uint32_t object = object_of(mesh_, triangle);
    return object == kNoObject || mesh_.objects[object].region < 0;
  }

 private:
  const Mesh& mesh_;
  bool has_rooms_;
};

/// An axis-aligned box.
struct Box {
  Vec3f low, high;
};
/// The smallest box around all triangles. \pre mesh has a triangle
Box bounds(const Mesh& mesh);

/// Normal of a triangle, of length 1, on the side from which its corners are counter-clockwise; +z
/// if it has no area.
/// \pre its indices are valid
Vec3f face_normal(const Mesh& mesh, std::size_t triangle);

/// Appends `part`, with its materials and objects. Optional lists that one of the two lacks are
/// filled with neutral values.
void append(Mesh& mesh, const Mesh& part);

/// Checks a mesh for faults that would make pictures of it wrong. Errors: `no-triangles`,
/// `bad-index` (of a position, material or object), `not-finite`, `list-length`, `bad-material`.
/// Warnings: `absurd-size` (less than 0.5 m or more than 2 km across: wrong units?),
/// `degenerate-triangles` (number of triangles without area), `missing-texture` (from readers).
/// `file` is the name in messages.
std::vector<Diagnostic> check(const Mesh& mesh, const std::string& file);

/// A segment of a cross-section.
struct SliceLine {
  Vec3f from, to;                    ///< world, metres; not equal
  std::uint32_t object = kNoObject;  ///< index in mesh.objects
};

/// Cross-section at height `z`, in the order of the triangles. Each triangle with a corner below z
/// and one at or above it gives a line. Triangles in the plane give none.
/// \pre check() finds no errors; z is finite
std::vector<SliceLine> slice(const Mesh& mesh, float z);

}  // namespace enfilade::mesh
