/// \file  The furniture that model homes have: how each piece is built, and how large it is.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/homes/furniture/furnish.h"

namespace enfilade::homes::furniture {

/// Metres: along the wall that it stands at, into the room, up.
struct Size {
  double w = 1, d = 1, h = 1;
};

/// What a shape is built with. Local frame: x from -w/2 to w/2, y from -d/2 (its back) to d/2 (its
/// front), z from 0 to h, also for what hangs on walls or from ceilings.
class Kit {
 public:
  Kit(mesh::MeshBuilder& builder, const looks::RoomStyle& room_style, Rng& random, Size size);

  const looks::RoomStyle& style;
  Rng& rng;
  const double w, d, h;
  double power = 1;  ///< of its lamps: a factor

  void box(const looks::NamedMaterial& m, Vec3d low, Vec3d high) { builder_.box(m.id, low, high); }
  void soft(const looks::NamedMaterial& m, Vec3d low, Vec3d high, double round) {
    builder_.soft_box(m.id, low, high, round);
  }
  void cylinder(const looks::NamedMaterial& m, Vec3d foot, double r0, double r1, double height,
                unsigned sides = 12) {
    builder_.cylinder(m.id, foot, r0, r1, height, sides);
  }
  void lathe(const looks::NamedMaterial& m, Vec3d foot,
             std::span<const std::array<double, 2>> profile, unsigned sides = 14,
             double stretch = 1) {
    builder_.lathe(m.id, foot, profile, sides, stretch);
  }
  void sphere(const looks::NamedMaterial& m, Vec3d middle, double radius, unsigned sides = 10) {
    builder_.sphere(m.id, middle, radius, sides);
  }
  void bar(const looks::NamedMaterial& m, Vec3d a, Vec3d b, double radius, unsigned sides = 6) {
    builder_.bar(m.id, a, b, radius, sides);
  }
  void quad(const looks::NamedMaterial& m, Vec3d p, Vec3d q, Vec3d r, Vec3d s) {
    builder_.quad(m.id, p, q, r, s);
  }
  /// A triangle; surfaces look alike from both sides.
  void leaf(const looks::NamedMaterial& m, Vec3d p, Vec3d q, Vec3d r);
  /// An open box with walls; its hollow goes down to `bottom` and narrows by `slope`.
  void hollow(const looks::NamedMaterial& m, Vec3d low, Vec3d high, double wall, double bottom,
              double slope = 0);
  /// Four of them below height z, `inset` from the sides; round or square.
  void legs(const looks::NamedMaterial& m, double z, double half, double inset, bool round = false);
  /// Doors or drawers over a front at y: columns x rows of panels with handles.
  void fronts(const looks::NamedMaterial& m, Vec3d low, Vec3d high, double y, unsigned columns,
              unsigned rows, bool knobs = false);
  /// Book spines standing on z from x0 to x1, at most `tall` and `deep` (from y towards the front).
  void books(double x0, double x1, double y, double z, double tall, double deep);

  /// What follows is beside what came before: its obstacles are boxes of their own.
  void part();
  /// The material that people would name it by.
  void spoken(const looks::NamedMaterial& m) {
    colour = m.colour;
    material = m.material;
  }
  void lamp(Vec3d local, double light);

  std::string colour, material;
  std::vector<std::size_t> parts;  ///< first triangle of each
  struct LampSpot {
    Vec3d local;
    double power;
  };
  std::vector<LampSpot> lamps;

 private:
  mesh::MeshBuilder& builder_;
};

struct Shape {
  std::string_view noun;
  std::uint16_t category;
  void (*build)(Kit& kit, int variant);
  int variant;
  Size size;
  std::string_view raw{};  ///< label in category_mapping.tsv where it is not the noun
};

// One table a file.
std::span<const Shape> seat_shapes();
std::span<const Shape> rest_shapes();
std::span<const Shape> table_shapes();
std::span<const Shape> storage_shapes();
std::span<const Shape> kitchen_shapes();
std::span<const Shape> bath_shapes();
std::span<const Shape> wall_shapes();
std::span<const Shape> lamp_shapes();
std::span<const Shape> decor_shapes();
std::span<const Shape> sport_shapes();

/// All tables, one after the other.
const std::vector<Shape>& all_shapes();
/// Every shape of that name, in the table's order; \pre there is one
std::vector<const Shape*> shapes_of(std::string_view noun);

/// Builds one and adds its obstacles (if a body could touch it), its thing and its lamps.
void build_shape(const Shape& shape, Size size, const mesh::Placement& at, std::size_t room,
                 const looks::RoomStyle& style, Rng& rng, looks::HomeParts& parts,
                 double power = 1);

}  // namespace enfilade::homes::furniture
