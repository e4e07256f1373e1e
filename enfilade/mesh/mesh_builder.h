/// \file  How synthetic homes put triangles together.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// Place of a material in the mesh that is being built.
struct MaterialId {
  std::uint32_t value = 0;
};

/// Pose of an object: turned about the vertical, then moved.
struct Placement {
  Vec3d position;     ///< metres, world: position of its local (0, 0, 0)
  double turned = 0;  ///< radians, counter-clockwise seen from above
  /// From the placement's frame into the world's.
  Vec3d to_world(Vec3d local) const;
};

/// Appends shapes to a mesh. A shape belongs to the current object and is given in the frame of the
/// current placement. Texture coordinates are metres divided by the material's `texture_size`, so
/// that a pattern has its true size on every shape. Normals point out of solids.
class MeshBuilder {
 public:
  /// \param mesh is appended to; must outlive *this
  explicit MeshBuilder(Mesh& mesh) : mesh_(mesh) {}

  /// \param texture_size metres that the texture's width covers; 0: stretched once over each face
  MaterialId add_material(Material material, double texture_size = 1);
  std::uint32_t begin_object(std::string name, std::uint16_t category, std::int32_t region,
                             const Placement& placement = {});
  /// The mesh built so far.
  const Mesh& mesh() const noexcept { return mesh_; }

  /// Corners counter-clockwise from the front. A texture that is stretched over the face
  /// (`texture_size` 0) has its bottom left corner at `a`. Other textures are upright and continue
  /// from face to face.
  void quad(MaterialId material, Vec3d a, Vec3d b, Vec3d c, Vec3d d);
  void triangle(MaterialId material, Vec3d a, Vec3d b, Vec3d c);
  /// From `low` to `high`, all six sides (or without the one below).
  void box(MaterialId material, Vec3d low, Vec3d high, bool bottom = true);
  /// A box with edges bevelled by `round` metres and shaded as if round: cushions, mattresses.
  void soft_box(MaterialId material, Vec3d low, Vec3d high, double round);
  /// Upright; a cone if the radii differ. Closed at both ends.
  void cylinder(MaterialId material, Vec3d foot, double radius0, double radius1, double height,
                unsigned sides = 16);
  /// A surface of revolution about a vertical axis. `profile` holds (radius, z), metres, from the
  /// bottom up along the outside, and down again along the inside for bowls. It is shaded smooth
  /// except at bends of more than 50 degrees, and is open at ends that do not lie on the axis.
  /// \param stretch radius along y divided by that along x
  void lathe(MaterialId material, Vec3d foot, std::span<const std::array<double, 2>> profile,
             unsigned sides = 20, double stretch = 1);
  void sphere(MaterialId material, Vec3d middle, double radius, unsigned sides = 14);
  /// A round bar between two points.
  void bar(MaterialId material, Vec3d a, Vec3d b, double radius, unsigned sides = 8);

 private:
  /// A corner of a triangle, local; the texture point in metres (or once over, for size 0).
  struct Corner {
    Vec3d position, normal;
    double u = 0, v = 0;
  };
  std::uint32_t vertex(Vec3d local);
  double texture_size(MaterialId material) const { return texture_sizes_.at(material.value); }
  void face(MaterialId material, const Corner& a, const Corner& b, const Corner& c);
  void patch(MaterialId material, const std::array<Corner, 4>& corners);
  void project(MaterialId material, std::span<Corner> corners, Vec3d normal) const;
  void disc(MaterialId material, Vec3d middle, Vec3d axis_u, Vec3d axis_v, Vec3d normal,
            unsigned sides);
  void mantle(MaterialId material, Vec3d foot, std::array<double, 2> low,
              std::array<double, 2> high, std::array<std::array<double, 2>, 2> normals,
              std::array<double, 2> v, unsigned sides, double stretch);

  Mesh& mesh_;
  std::vector<double> texture_sizes_;
  Placement placement_;
  std::uint32_t object_ = kNoObject;
  /// Vertices of the current object: corners at one point share a position, so that solids are
  /// closed.
  std::map<std::array<float, 3>, std::uint32_t> vertices_;
};

}  // namespace enfilade::mesh
