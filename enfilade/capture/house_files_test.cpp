#include "enfilade/capture/scan_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "enfilade/core/errors.h"
#include "enfilade/scan/matterport_cameras.h"
#include "enfilade/scan/panorama_source.h"
#include "tests/support/furnished_room.h"

namespace enfilade::capture {
namespace EN_UNIT {

using mesh::Mesh;

HouseFiles files() {
  return make_house_files(tests::furnished_rooms(), tests::furnished_room_graph(),
                          tests::furnished_room_list());
}

std::size_t object_named(const Mesh& mesh, const std::string& name) {
  const auto found = std::ranges::find(mesh.objects, name, &mesh::Object::name);
  EXPECT_NE(found, mesh.objects.end());
  return static_cast<std::size_t>(found - mesh.objects.begin());
}

TEST(HouseFiles, HaveTheRoomsAsRegionsWithTheirFloors) {
  const mesh::House house = files().house;
  EXPECT_EQ(house.name, "rooms");
  ASSERT_EQ(house.levels.size(), 1U);
  EXPECT_EQ(house.levels[0].box.high, (Vec3d{7.5, 5, 2.7}));
  ASSERT_EQ(house.regions.size(), 2U);
  EXPECT_EQ(house.regions[0].label, 'l');
  EXPECT_EQ(house.regions[1].label, 'b');
  EXPECT_EQ(house.regions[1].height, 2.7);
  ASSERT_EQ(house.surfaces.size(), 2U);
  EXPECT_EQ(house.surfaces[1].region, 1);
  EXPECT_EQ(house.surfaces[1].label, 'F');
  // Four corners a floor, counter-clockwise from above: the shoelace sum is its area.
  ASSERT_EQ(house.vertices.size(), 8U);
  double twice_area = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3d p = house.vertices[4 + k].position, q = house.vertices[4 + (k + 1) % 4].position;
    EXPECT_EQ(house.vertices[4 + k].surface, 1);
    twice_area += p.x * q.y - q.x * p.y;
  }
  EXPECT_NEAR(twice_area / 2, 3.45 * 5, 1e-12);
}

TEST(HouseFiles, HaveIncludedViewpointsWithTheirEighteenImages) {
  const mesh::House house = files().house;
  ASSERT_EQ(house.panoramas.size(), 2U);
  EXPECT_EQ(house.panoramas[0].name, "a");
  EXPECT_EQ(house.panoramas[0].region, 0);
  EXPECT_EQ(house.panoramas[1].region, 1);
  ASSERT_EQ(house.images.size(), 36U);
  const auto rig = scan::rig_cameras(scan::poses_of(tests::furnished_room_graph())[1]);
  for (std::size_t k = 0; k < 18; ++k) {
    const mesh::HouseImage& image = house.images[18 + k];
    EXPECT_EQ(image.panorama, 1);
    EXPECT_EQ(image.camera, static_cast<std::int32_t>(rig[k].camera));
    EXPECT_EQ(image.yaw, static_cast<std::int32_t>(rig[k].yaw));
    // Extrinsics take the camera's own place to the origin, and what is ahead to -z.
    const auto in_camera = [&](Vec3d p) {
      const auto& e = image.camera_from_world;
      return Vec3d{e[0] * p.x + e[1] * p.y + e[2] * p.z + e[3],
                   e[4] * p.x + e[5] * p.y + e[6] * p.z + e[7],
                   e[8] * p.x + e[9] * p.y + e[10] * p.z + e[11]};
    };
    EXPECT_LT(length(in_camera(rig[k].position)), 1e-12);
    const Vec3d ahead = rig[k].position + rig[k].world_from_camera * Vec3d{0, 0, 2};
    EXPECT_LT(length(in_camera(ahead) - Vec3d{0, 0, -2}), 1e-12);
    EXPECT_EQ(image.intrinsics[0], rig[k].fx);
    EXPECT_EQ(image.intrinsics[5], 1023 - rig[k].cy) << "rows are counted from the bottom";
  }
}

TEST(HouseFiles, KeepObjectsPlacesRegionsAndClasses) {
  const Mesh mesh = tests::furnished_rooms();
  const mesh::House house = files().house;
  ASSERT_EQ(house.objects.size(), mesh.objects.size());
  for (std::size_t k = 0; k < house.objects.size(); ++k) {
    const mesh::HouseObject& object = house.objects[k];
    EXPECT_EQ(object.region, mesh.objects[k].region);
    const auto& category = house.categories.at(static_cast<std::size_t>(object.category));
    EXPECT_EQ(category.mpcat40_index, mesh.objects[k].category);
  }
  const mesh::HouseObject& bed = house.objects[object_named(mesh, "bed")];
  EXPECT_LT(length(bed.position - Vec3d{6.3, 1.1, .275}), 1e-6);  // floats
  EXPECT_LT(length(bed.radii - Vec3d{.8, 1, .275}), 1e-6);
  // One record a class, not one an object: there are two walls.
  std::set<std::string> names;
  for (const auto& category : house.categories) names.insert(category.mpcat40_name);
  EXPECT_EQ(names.size(), house.categories.size());
  EXPECT_TRUE(names.contains("lighting"));
}

TEST(HouseFiles, CutObjectsIntoConnectedPieces) {
  const Mesh mesh = tests::furnished_rooms();
  const HouseFiles made = files();
  std::map<std::int32_t, std::size_t> pieces;
  for (const mesh::HouseSegment& s : made.house.segments) ++pieces[s.object];
  const auto of = [&](const std::string& name) {
    return pieces[static_cast<std::int32_t>(object_named(mesh, name))];
  };
  EXPECT_EQ(of("floor"), 1U);
  EXPECT_EQ(of("coffee table"), 5U);  // a top and four legs, which share no corner
  EXPECT_EQ(of("sofa"), 1U);          // seat and back share corners
  EXPECT_EQ(of("lamp"), 2U);
  EXPECT_EQ(pieces[-1], 1U);  // the box of no object
  // The floor's two triangles are its area; a segment's number is that of its triangles.
  const auto floor =
      std::ranges::find(made.house.segments, static_cast<std::int32_t>(object_named(mesh, "floor")),
                        &mesh::HouseSegment::object);
  EXPECT_NEAR(floor->area, 37.5, 1e-9);
  for (std::size_t t = 0; t < made.segments.size(); ++t) {
    const auto segment = static_cast<std::size_t>(made.segments[t]);
    const std::uint32_t object = mesh.triangle_object[t];
    ASSERT_LT(segment, made.house.segments.size());
    EXPECT_EQ(made.house.segments[segment].object,
              object == mesh::kNoObject ? -1 : static_cast<std::int32_t>(object));
    EXPECT_EQ(made.labels.face_object[t], made.house.segments[segment].object);
  }
}

TEST(HouseFiles, GroupSegmentsByObjectWithItsRawLabel) {
  const Mesh mesh = tests::furnished_rooms();
  const HouseFiles made = files();
  const auto table = std::ranges::find(made.groups, "coffee table", &mesh::SegmentGroup::label);
  ASSERT_NE(table, made.groups.end());
  EXPECT_EQ(table->id, static_cast<std::int32_t>(object_named(mesh, "coffee table")));
  EXPECT_EQ(table->segments.size(), 5U);
  std::size_t grouped = 0;
  for (const auto& group : made.groups) grouped += group.segments.size();
  EXPECT_EQ(grouped + 1, made.house.segments.size()) << "all but the box of no object";
}

TEST(HouseFiles, GiveVerticesTheColourOfTheirSurface) {
  const Mesh mesh = tests::furnished_rooms();
  const HouseFiles made = files();
  const auto bed = static_cast<std::uint32_t>(object_named(mesh, "picture"));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.triangle_object[t] != bed) continue;
    const Vec3f colour = made.labels.mesh.colours[mesh.triangles[t][0]];
    EXPECT_FLOAT_EQ(colour.x, .6F);
    EXPECT_FLOAT_EQ(colour.z, .12F);
  }
}

TEST(HouseFiles, AreOneRegionWhereNoRoomsAreKnown) {
  Mesh mesh = tests::furnished_rooms();
  for (mesh::Object& object : mesh.objects) object.category = 0, object.region = -1;
  const mesh::House house = make_house_files(mesh, tests::furnished_room_graph(), {}).house;
  ASSERT_EQ(house.regions.size(), 1U);
  EXPECT_EQ(house.regions[0].label, 'z');
  EXPECT_TRUE(house.categories.empty());
  for (const auto& object : house.objects) {
    EXPECT_EQ(object.region, 0);
    EXPECT_EQ(object.category, -1);
  }
  for (const auto& panorama : house.panoramas) EXPECT_EQ(panorama.region, 0);
}

TEST(HouseFiles, RefuseWhatIsNoCategory) {
  Mesh mesh = tests::furnished_rooms();
  mesh.objects[3].category = 42;
  EXPECT_THROW(make_house_files(mesh, tests::furnished_room_graph(), {}), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::capture
