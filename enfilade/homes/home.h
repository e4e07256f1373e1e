/// \file  Model homes: made-up, furnished buildings with the truth about everything in them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/homes/plan.h"
#include "enfilade/mesh/lighting.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::homes {

/// A solid object of the generator: a box that may be turned about the vertical.
struct Obstacle {
  double x = 0, y = 0;            ///< middle, metres
  double half_x = 0, half_y = 0;  ///< before turning
  double turned = 0;              ///< radians, counter-clockwise
  double z0 = 0, z1 = 0;          ///< lowest and highest point, world
};

/// Something that an instruction may mention.
struct HomeThing {
  std::uint32_t object = 0;  ///< its place in mesh.objects
  std::string noun;          ///< "sofa", "bookshelf"
  std::string colour;        ///< "red"; empty: not mentioned
  std::string material;      ///< "wooden", "marble"; may be empty
  std::size_t room = 0;      ///< place in plan.rooms
  Vec3d low, high;           ///< box along the axes, world
};

/// A furnished building.
struct Home {
  Plan plan;
  mesh::Mesh mesh;  ///< objects' region: place in plan.rooms
  mesh::Lights lights;
  std::vector<Obstacle> obstacles;  ///< walls, leaves, furniture: all that a body could touch
  std::vector<HomeThing> things;
};

/// Whether the materials of a home get their textures. They take two thirds of the time that a home
/// without pictures takes; everything else is the same without them.
enum class HomeSurfaces : std::uint8_t { kTextured, kPlain };

/// Makes a synthetic home. The same options give the same home, to the byte, on every platform.
/// \throws ArgumentError as make_plan()
Home make_home(const PlanOptions& options, HomeSurfaces surfaces = HomeSurfaces::kTextured);

/// The room whose floor or stairs hold the point; on a threshold, the nearer room. No value for
/// points more than 0.5 m from every room.
std::optional<std::size_t> room_at(const Plan& plan, Vec3d floor_point);

}  // namespace enfilade::homes
