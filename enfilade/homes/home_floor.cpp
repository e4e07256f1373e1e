#include "enfilade/homes/home_floor.h"

#include <algorithm>
#include <limits>

namespace enfilade::homes {

namespace {

constexpr double kAround = 1;  // metres beside the rooms: their walls, and thresholds

mesh::Box around_rooms(const Plan& plan) {
  constexpr double kFar = std::numeric_limits<double>::max();
  Rect rooms{kFar, kFar, -kFar, -kFar};
  for (const PlanRoom& room : plan.rooms) {
    rooms = {std::min(rooms.x0, room.floor.x0), std::min(rooms.y0, room.floor.y0),
             std::max(rooms.x1, room.floor.x1), std::max(rooms.y1, room.floor.y1)};
  }
  const Storey& top = plan.storeys.back();
  return {to_float(Vec3d{rooms.x0 - kAround, rooms.y0 - kAround, plan.storeys.front().floor - 0.5}),
          to_float(Vec3d{rooms.x1 + kAround, rooms.y1 + kAround, top.floor + top.height})};
}

}  // namespace

mesh::FloorPolygons make_home_floor(const BuiltHome& built, const mesh::Body& body) {
  mesh::PolygonOptions options;
  options.floor.body = body;
  options.floor.within = around_rooms(built.home.plan);
  return mesh::make_floor_polygons(*built.tracer, options);
}

}  // namespace enfilade::homes
