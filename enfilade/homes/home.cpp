#include "enfilade/homes/home.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "enfilade/core/rng.h"
#include "enfilade/homes/furniture/furnish_room.h"
#include "enfilade/homes/looks/architecture.h"
#include "enfilade/homes/looks/style.h"

namespace enfilade::homes {
namespace {

// Mid-morning to mid-afternoon: low enough to shine in, high enough not to blind.
constexpr double kLowestSun = 28, kHighestSun = 55;  // degrees

mesh::Sun draw_sun(Rng rng) {
  const double around = 2 * std::numbers::pi * rng.uniform();
  const double up =
      (kLowestSun + (kHighestSun - kLowestSun) * rng.uniform()) * std::numbers::pi / 180;
  mesh::Sun sun;
  sun.towards = {static_cast<float>(std::cos(up) * std::cos(around)),
                 static_cast<float>(std::cos(up) * std::sin(around)),
                 static_cast<float>(std::sin(up))};
  // About five times the sky's, warmer the lower it stands.
  const auto warm = static_cast<float>(std::sin(up));
  sun.irradiance = {30, 22 + 5 * warm, 14 + 10 * warm};
  sun.radius = 0.01F;  // of a thin haze: shadows' edges are 5 cm wide at 2.5 m
  return sun;
}

// Distance to a rectangle, from a point outside it; 0 inside.
double distance_to(const Rect& rect, Vec3d p) {
  const double x = std::max({rect.x0 - p.x, p.x - rect.x1, 0.0});
  const double y = std::max({rect.y0 - p.y, p.y - rect.y1, 0.0});
  return std::hypot(x, y);
}

}  // namespace

std::optional<std::size_t> room_at(const Plan& plan, Vec3d floor_point) {
  constexpr double kNear = 0.5, kBelow = 0.3;
  // The storey whose floor is the last below: on stairs, the one that they begin at.
  unsigned storey = 0;
  for (unsigned s = 1; s < plan.storeys.size(); ++s) {
    if (plan.storeys[s].floor <= floor_point.z + kBelow) storey = s;
  }
  std::optional<std::size_t> found;
  double nearest = kNear;
  for (std::size_t r = 0; r < plan.rooms.size(); ++r) {
    if (plan.rooms[r].storey != storey) continue;
    const double distance = distance_to(plan.rooms[r].floor, floor_point);
    if (distance < nearest) {
      nearest = distance;
      found = r;
    }
  }
  return found;
}

Home make_home(const PlanOptions& options, HomeSurfaces surfaces) {
  Home home;
  home.plan = make_plan(options);
  mesh::MeshBuilder builder(home.mesh);
  const std::vector<looks::RoomStyle> styles = looks::make_styles(home.plan, builder, surfaces);
  const looks::HomeParts parts{builder, home.obstacles, home.things, home.lights.lamps};
  looks::build_architecture(home.plan, styles, parts, home.lights.portals);
  for (const looks::RoomSpace& space : looks::room_spaces(home.plan)) {
    // A stream a room: what is drawn in one does not change the others.
    Rng rng(options.seed, stream_of("furnish", 7), space.room);
    furniture::furnish(space, styles[space.room], rng, parts);
  }
  home.lights.sun = draw_sun(Rng(options.seed, stream_of("sun", 3)));
  return home;
}

}  // namespace enfilade::homes
