#include "enfilade/capture/plain_room.h"

#include <gtest/gtest.h>
#include <memory>

#include "enfilade/mesh/mesh_builder.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/mesh/ray_tracer.h"

namespace enfilade::capture {
namespace EN_UNIT {

/// Three tables whose legs end at different heights, and a lamp in the air.
mesh::Mesh things() {
  mesh::Mesh mesh;
  mesh::MeshBuilder b(mesh);
  const auto wood = b.add_material({});
  for (const double low : {-.2, -.1, -.08}) {
    b.begin_object("table", mesh::Mpcat40::kTable, -1);
    b.box(wood, {10 * low, 0, low}, {10 * low + .5, 1, .7});
  }
  b.begin_object("lamp", mesh::Mpcat40::kLighting, -1);
  b.box(wood, {3, 3, 1.5}, {3.2, 3.2, 2.0});
  return mesh;
}

TEST(PlainRoom, StandsBelowMostThingsAndAroundAll) {
  mesh::Mesh mesh = things();
  add_plain_room(mesh);
  EXPECT_TRUE(mesh::check(mesh, "room").empty());
  const auto shared = std::make_shared<const mesh::Mesh>(mesh);
  const mesh::RayTracer tracer(shared);
  const auto what = [&](Vec3f direction, float expected_distance) {
    const mesh::Hit hit = tracer.trace({{1, 2, 1.4F}, direction});
    EXPECT_NEAR(hit.distance, expected_distance, 1e-4);
    return shared->objects.at(shared->triangle_object.at(hit.triangle)).category;
  };
  // The floor is at the middle one's -0.1; walls are 1.5 m from the box x -2 .. 3.2, y 0 .. 3.2.
  EXPECT_EQ(what({0, 0, -1}, 1.5F), 2);
  EXPECT_EQ(what({0, 0, 1}, 1.5F), 17);  // 3 m above the floor
  EXPECT_EQ(what({1, 0, 0}, 3.7F), 1);
  EXPECT_EQ(what({-1, 0, 0}, 4.5F), 1);
  EXPECT_EQ(what({0, 1, 0}, 2.7F), 1);
  EXPECT_EQ(what({0, -1, 0}, 3.5F), 1);
}

TEST(PlainRoom, IsAsHighAsWhatStandsInIt) {
  mesh::Mesh mesh = things();
  mesh.positions.back().z = 4;
  add_plain_room(mesh);
  EXPECT_FLOAT_EQ(mesh::bounds(mesh).high.z, 4.3F);
}

}  // namespace EN_UNIT
}  // namespace enfilade::capture
