/// \file  Triangles with materials and labels: a building as rays meet it.
#pragma once
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

/// Where in a texture: (0, 0) is the middle of nothing but the top left corner of the picture, u to
/// the right, v down; beyond [0, 1] the picture repeats.
struct TexturePoint {
  float u = 0, v = 0;
};

/// How a surface sends light back. Both sides look alike.
struct Material {
  std::string name;
  Vec3f colour{0.8F, 0.8F, 0.8F};  ///< linear reflectance in [0, 1]; multiplies the texture
  Vec3f emission;                  ///< linear radiance that it sends out itself; >= 0
  float mirror = 0;                ///< share of light reflected as by a mirror, [0, 1]
  image::Image8 texture;           ///< sRGB, 3 channels, or 4 with cut-outs; empty: none
  float cutout = 0;                ///< > 0: no surface where the texture's alpha is below; [0, 1]
  std::string texture_file;        ///< where the texture was read; empty: made, or none
};

/// A thing that has a place of its own in instance pictures.
struct Object {
  std::string name;            ///< raw label, as "coffee table"
  std::uint16_t category = 0;  ///< index of mpcat40; 0: void
  std::int32_t region = -1;    ///< room that it stands in; -1: none
};

inline constexpr std::uint32_t kNoObject = std::numeric_limits<std::uint32_t>::max();

/// A plain value. World frame: metres, +z up, right-handed. Optional lists are empty or as long as
/// the list that they belong to.
struct Mesh {
  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< places in positions
  std::vector<std::uint32_t> triangle_material;         ///< place in materials, one a triangle
  std::vector<std::uint32_t> triangle_object;           ///< place in objects or kNoObject; optional
  std::vector<std::array<TexturePoint, 3>> texture_points;  ///< of each corner; optional
  std::vector<std::array<Vec3f, 3>> normals;  ///< of each corner, length 1, for shading; optional
  std::vector<Vec3f> colours;                 ///< linear, of each position; optional; multiplies
  std::vector<Material> materials;
  std::vector<Object> objects;  ///< object k is instance k + 1 in pictures; 0 there: none
};

/// The smallest box with sides along the axes that holds all triangles.
struct Box {
  Vec3f low, high;
};
/// \pre mesh has a triangle
Box bounds(const Mesh& mesh);

/// Of length 1, towards where the corners are seen counter-clockwise; +z if it has no area. \pre
/// its corners are there
Vec3f face_normal(const Mesh& mesh, std::size_t triangle);

/// Appends `part`; its materials and objects become new ones. Optional lists are filled up with
/// neutral values where one of the two lacks them.
void append(Mesh& mesh, const Mesh& part);

/// What would make rays or pictures of it meaningless. Errors: `no-triangles`, `bad-index` (a
/// position, material or object that is not there), `not-finite`, `list-length`, `bad-material`.
/// Warnings: `absurd-size` (its box is less than 0.5 m or more than 2 km across: wrong units?),
/// `degenerate-triangles` (how many have no area), `missing-texture` (from readers). `file` is the
/// name in messages.
std::vector<Diagnostic> check(const Mesh& mesh, const std::string& file);

}  // namespace enfilade::mesh
