/// \file  The furniture of synthetic homes: how each piece is built, and how large it is.
#pragma once
#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/homes/looks/style.h"

namespace enfilade::homes::furniture {

using looks::NamedMaterial;
using Style = looks::RoomStyle;
using Ring = std::array<double, 2>;  ///< of a lathe's profile: radius, height

/// Metres: along the wall that it stands at, into the room, up.
struct FurnitureSize {
  double w = 1, d = 1, h = 1;
};

/// A box by its corners.
struct BlockCorners {
  Vec3d low, high;
};

struct FurnitureShape;

/// Builder of a shape. Local frame: x from -w/2 to w/2, y from -d/2 (back) to d/2 (front), z from 0
/// to h. The same for shapes that hang on walls or from ceilings.
class Kit {
 public:
  Kit(mesh::MeshBuilder& builder, const Style& room_style, Rng& random, const FurnitureShape& shape,
      FurnitureSize size);

  const Style& style;
  Rng& rng;
  const double w, d, h;
  const int variant;
  const NamedMaterial main;  ///< the room's material for Shape::main
  double power = 1;          ///< of its lamps: a factor

  void box(const NamedMaterial& m, Vec3d low, Vec3d high) { builder_.box(m.id, low, high); }
  void soft(const NamedMaterial& m, Vec3d low, Vec3d high, double round) {
    builder_.soft_box(m.id, low, high, round);
  }
  void cylinder(const NamedMaterial& m, Vec3d foot, double r0, double r1, double height,
                unsigned sides = 12) {
    builder_.cylinder(m.id, foot, r0, r1, height, sides);
  }
  /// A surface of revolution through the rings. `stretch`: as in MeshBuilder::lathe().
  template <class... Rings>
  void lathe(const NamedMaterial& m, Vec3d foot, unsigned sides, double stretch, Rings... rings) {
    builder_.lathe(m.id, foot, std::array<Ring, sizeof...(rings)>{rings...}, sides, stretch);
  }
  void sphere(const NamedMaterial& m, Vec3d middle, double radius, unsigned sides = 10) {
    builder_.sphere(m.id, middle, radius, sides);
  }
  void bar(const NamedMaterial& m, Vec3d a, Vec3d b, double radius, unsigned sides = 6) {
    builder_.bar(m.id, a, b, radius, sides);
  }
  void quad(const NamedMaterial& m, Vec3d p, Vec3d q, Vec3d r, Vec3d s) {
    builder_.quad(m.id, p, q, r, s);
  }
  void triangle(const NamedMaterial& m, Vec3d p, Vec3d q, Vec3d r) {
    builder_.triangle(m.id, p, q, r);
  }
  /// Blocks at +x and their mirror images at -x, which are built first; with `round`, soft.
  void pairs(const NamedMaterial& m, std::initializer_list<BlockCorners> blocks, double round = 0);
  /// Legs that lean inwards: bars from a circle of radius r0 at height z0 to one of r1 at z1. The
  /// first stands at `first` of the way to the second.
  void splayed_legs(const NamedMaterial& m, int count, double first, std::array<Ring, 2> ends,
                    double radius, unsigned sides = 6);
  /// An open box with walls; its hollow goes down to `bottom` and narrows by `slope`.
  void hollow(const NamedMaterial& m, Vec3d low, Vec3d high, double wall, double bottom,
              double slope = 0);
  /// Four of them below height z, `inset` from the sides; round or square.
  void legs(const NamedMaterial& m, double z, double half, double inset, bool round = false);
  /// Doors or drawers over a front at y: columns x rows of panels with handles.
  void fronts(const NamedMaterial& m, Vec3d low, Vec3d high, double y, unsigned columns,
              unsigned rows, bool knobs = false);
  /// Book spines standing on z from x0 to x1, at most `tall` and `deep` (from y towards the front).
  void books(double x0, double x1, double y, double z, double tall, double deep);

  /// Starts a new part, with obstacles of its own.
  void part() { parts.push_back(builder_.mesh().triangles.size()); }
  /// Names the piece by another material than `main`, and returns it.
  const NamedMaterial& spoken(const NamedMaterial& m) {
    colour = m.colour;
    material = m.material;
    return m;
  }
  void lamp(Vec3d local, double light) { lamps.push_back({local, light * power}); }

  std::string colour, material;    ///< how people would name it; at first those of `main`
  std::vector<std::size_t> parts;  ///< first triangle of each
  struct LampSpot {
    Vec3d local;
    double power;
  };
  std::vector<LampSpot> lamps;

 private:
  mesh::MeshBuilder& builder_;
};

struct FurnitureShape {
  std::string_view noun;
  std::uint16_t category;
  void (*build)(Kit& kit, double x, double y);  ///< x, y: half of its width and depth
  int variant;                                  ///< number of the form that `build` makes
  FurnitureSize size;
  NamedMaterial Style::*main;  ///< its main material, which names it; null: none
  std::string_view raw{};      ///< label in category_mapping.tsv where it is not the noun
};

// The shapes of each file.
std::span<const FurnitureShape> seat_shapes();     ///< and beds, with what stands beside them
std::span<const FurnitureShape> storage_shapes();  ///< and tables, and sports equipment
std::span<const FurnitureShape> wet_shapes();      ///< of kitchens and bathrooms
std::span<const FurnitureShape> wall_shapes();     ///< and lamps
std::span<const FurnitureShape> decor_shapes();

/// All tables, one after the other.
const std::vector<FurnitureShape>& all_shapes();
/// Every shape of that name, in the table's order. \pre there is one
std::vector<const FurnitureShape*> shapes_of(std::string_view noun);
/// The shape of that name at place `which` of shapes_of().
const FurnitureShape& shape_of(std::string_view noun, std::size_t which = 0);

/// Builds one and adds its obstacles (if a body could touch it), its object and its lamps.
void build_shape(const FurnitureShape& shape, FurnitureSize size, const mesh::Placement& at,
                 std::size_t room, const Style& style, Rng& rng, looks::HomeParts& parts,
                 double power = 1);

}  // namespace enfilade::homes::furniture
