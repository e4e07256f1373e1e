#include "enfilade/capture/object_boxes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/mesh/capture.h"
#include "enfilade/mesh/lighting.h"
#include "enfilade/mesh/mesh_builder.h"
#include "enfilade/tasks/objects.h"
#include "tests/support/refusal.h"

namespace enfilade::capture {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using enum mesh::Mpcat40::Category;

constexpr std::uint32_t kRoom = 0, kTallChair = 1, kPlantBehind = 2, kFarSofa = 3, kHidden = 4;
constexpr Vec3f kEye{0, 0, 1.5F};

// A room, a chair to the north, a plant half behind it, a sofa far to the east, and a lamp in the
// chair.
std::shared_ptr<const mesh::Mesh> furnished() {
  mesh::Mesh mesh;
  mesh::MeshBuilder builder(mesh);
  const auto grey = builder.add_material({});
  builder.begin_object("room", kWall, 0);
  for (const auto& [low, high] : {std::pair{Vec3d{-6, -6, -0.1}, Vec3d{6, 6, 0}},
                                  std::pair{Vec3d{-6, 5, 0}, Vec3d{6, 6, 3}}}) {
    builder.box(grey, low, high);
  }
  builder.begin_object("chair", kChair, 0);
  builder.box(grey, {-0.5, 2, 0}, {0.5, 2.4, 1.75});
  builder.begin_object("plant", kPlant, 0);
  builder.box(grey, {0.25, 2.5, 1}, {1, 2.75, 2});
  builder.begin_object("sofa", kSofa, 0);
  builder.box(grey, {4, -1, 0}, {5, 1, 0.75});
  builder.begin_object("lamp", kLighting, 0);
  builder.box(grey, {-0.1, 2.1, 0.5}, {0.1, 2.2, 0.6});
  return std::make_shared<const mesh::Mesh>(std::move(mesh));
}

const mesh::RayTracer& tracer() {
  static const mesh::RayTracer kTracer(furnished());
  return kTracer;
}

std::map<std::uint32_t, ObjectInView> seen_with(std::uint32_t around, double farthest = 3) {
  ObjectBoxOptions options;
  options.around = around;
  options.farthest = farthest;
  std::map<std::uint32_t, ObjectInView> found;
  for (const ObjectInView& one : objects_in_view(tracer(), kEye, options)) found[one.object] = one;
  return found;
}

TEST(ObjectBoxes, AreWhatThePicturesShow) {
  const auto found = seen_with(0);
  EXPECT_EQ(found.size(), 2U) << "the sofa is too far, the lamp is hidden, walls are no objects";
  ASSERT_TRUE(found.contains(kTallChair) && found.contains(kPlantBehind));
  const ObjectInView& chair = found.at(kTallChair);
  // Its nearest point in view is straight ahead, at (0, 2, 1.5).
  EXPECT_NEAR(chair.distance, 2, 1e-3);
  // Its front is from -0.5 to 0.5 m at 2 m; its lower edge is 1.5 m below.
  EXPECT_NEAR(chair.left, 2 * kPi - std::atan2(0.5, 2.0), 2e-3);
  EXPECT_NEAR(chair.right, std::atan2(0.5, 2.0), 2e-3);
  EXPECT_NEAR(chair.top, std::atan2(0.25, 2.0), 2e-3);
  EXPECT_NEAR(chair.bottom, -std::atan2(1.5, 2.0), 2e-3);
  EXPECT_NEAR(std::remainder(chair.middle.heading.value, 2 * kPi), 0, 0.02);
  // View 12 looks north, level: 415.7 pixels for a tangent of 1. The bottom is cut off.
  const auto at = std::ranges::find(chair.views, 12);
  ASSERT_NE(at, chair.views.end());
  const double focal = 240 / std::tan(kPi / 6);
  const auto& box = chair.boxes[static_cast<std::size_t>(at - chair.views.begin())];
  EXPECT_NEAR(box[0], 320 - focal / 4, 1.01);
  EXPECT_NEAR(box[1], 240 - focal / 8, 1.01);
  EXPECT_NEAR(box[2], focal / 2, 2.01);
  EXPECT_EQ(box[1] + box[3], 480);
  EXPECT_EQ(std::ranges::count(chair.views, 18), 0) << "behind";
}

TEST(ObjectBoxes, OfSharedRaysAreNearThoseOfAllPixels) {
  const auto exact = seen_with(0), shared = seen_with(720);
  ASSERT_EQ(exact.size(), shared.size());
  for (const auto& [object, one] : exact) {
    const ObjectInView& other = shared.at(object);
    EXPECT_NEAR(other.distance, one.distance, 0.02);
    // Pixels count in the nearest view only, whose picture's corners lack some of its share.
    EXPECT_NEAR(other.share, one.share, 0.06 * one.share);
    EXPECT_NEAR(std::remainder(other.left - one.left, 2 * kPi), 0, 0.01);
    EXPECT_NEAR(std::remainder(other.right - one.right, 2 * kPi), 0, 0.01);
    EXPECT_NEAR(other.top, one.top, 0.01);
    EXPECT_NEAR(other.bottom, one.bottom, 0.01);
    std::size_t compared = 0;
    for (std::size_t k = 0; k < one.views.size(); ++k) {
      const auto same = std::ranges::find(other.views, one.views[k]);
      if (one.boxes[k][2] < 12 || one.boxes[k][3] < 12) continue;  // hardly in the picture
      ASSERT_NE(same, other.views.end()) << object << " in view " << int{one.views[k]};
      const auto& box = other.boxes[static_cast<std::size_t>(same - other.views.begin())];
      EXPECT_NEAR(box[0], one.boxes[k][0], 6);
      EXPECT_NEAR(box[1], one.boxes[k][1], 6);
      EXPECT_NEAR(box[0] + box[2], one.boxes[k][0] + one.boxes[k][2], 6);
      EXPECT_NEAR(box[1] + box[3], one.boxes[k][1] + one.boxes[k][3], 6);
      ++compared;
    }
    EXPECT_GE(compared, 4U);
  }
}

// The instance picture of a view, drawn by the code that draws all pictures.
image::Image32 picture_of(int view) {
  const double heading = view % 12 * kPi / 6, elevation = (view / 12 - 1) * kPi / 6;
  const double s = std::sin(heading), c = std::cos(heading);
  const double se = std::sin(elevation), ce = std::cos(elevation);
  mesh::Pinhole camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 240 / std::tan(kPi / 6);
  camera.cx = 319.5;
  camera.cy = 239.5;
  // Columns: x right, y down, z forward.
  camera.world_from_camera = {{c, s * se, s * ce, -s, c * se, c * ce, 0, -ce, se}};
  camera.position = to_double(kEye);
  mesh::BakeOptions bake;
  bake.rays = 4;
  const mesh::LitMesh lit(std::make_shared<mesh::RayTracer>(furnished()), {}, bake);
  mesh::CaptureOptions options;
  options.colour = options.depth = false;
  return capture_pinhole(lit, camera, options).instances;
}

TEST(ObjectBoxes, AgreeWithInstancePictures) {
  const auto found = seen_with(0, 100);
  for (const int view : {11, 12, 13, 0, 1, 15}) {
    const image::Image32 picture = picture_of(view);
    std::map<std::uint32_t, std::array<std::int32_t, 5>> boxes;  // x0, y0, x1, y1, pixels
    for (std::int32_t y = 0; y < 480; ++y) {
      for (std::int32_t x = 0; x < 640; ++x) {
        const std::uint32_t label =
            picture.pixels[static_cast<std::size_t>(y) * 640 + static_cast<std::size_t>(x)];
        if (label == 0 || label == kRoom + 1) continue;
        auto& box = boxes.try_emplace(label - 1, std::array{x, y, x, y, 0}).first->second;
        box = {std::min(box[0], x), std::min(box[1], y), std::max(box[2], x + 1),
               std::max(box[3], y + 1), box[4] + 1};
      }
    }
    for (const auto& [object, one] : found) {
      const auto at = std::ranges::find(one.views, view);
      const auto truth = boxes.find(object);
      const bool in = truth != boxes.end() && truth->second[4] >= 50;
      ASSERT_EQ(at != one.views.end(), in) << object << " in view " << view;
      if (!in) continue;
      const auto& box = one.boxes[static_cast<std::size_t>(at - one.views.begin())];
      const auto& wanted = truth->second;
      EXPECT_NEAR(box[0], wanted[0], 1);
      EXPECT_NEAR(box[1], wanted[1], 1);
      EXPECT_NEAR(box[0] + box[2], wanted[2], 1);
      EXPECT_NEAR(box[1] + box[3], wanted[3], 1);
    }
  }
  EXPECT_TRUE(found.contains(kFarSofa));
  EXPECT_FALSE(found.contains(kHidden));
}

TEST(ObjectBoxes, OfAScanHaveIdsNamesAndAllViewpoints) {
  scan::Connectivity graph{"room", "", {}};
  for (const auto& [id, x] : {std::pair{"a", 0.0}, std::pair{"b", -5.0}, std::pair{"c", 2.0}}) {
    scan::ConnectivityEntry entry;
    entry.id = id;
    entry.pose = {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 1.5, 0, 0, 0, 1};
    graph.entries.push_back(entry);
  }
  graph.entries[2].included = false;
  const tasks::ObjectBoxes boxes = compute_object_boxes(tracer(), graph);
  ASSERT_THAT(boxes.at("room", "a"), SizeIs(2));
  EXPECT_EQ(boxes.at("room", "a")[0].id, kTallChair);
  EXPECT_EQ(boxes.at("room", "a")[0].name, "chair");
  EXPECT_TRUE(boxes.has("room", "b"));
  EXPECT_THAT(boxes.at("room", "b"), SizeIs(0));
  EXPECT_FALSE(boxes.has("room", "c"));
  EXPECT_THAT(boxes.seen_from("room", kTallChair), ElementsAre("a"));
  EXPECT_EQ(tasks::ObjectBoxes::parse(boxes.to_json(false), "").to_json(true), boxes.to_json(true));
}

TEST(ObjectBoxes, RefuseOptionsOutOfRange) {
  const auto refusal_of = [](const auto& change) {
    ObjectBoxOptions options;
    change(options);
    return tests::refusal<ArgumentError>([&] { objects_in_view(tracer(), kEye, options); });
  };
  EXPECT_THAT(refusal_of([](ObjectBoxOptions& o) { o.around = 35; }),
              HasSubstr("around: 35 rays, neither 0 nor from 36"));
  EXPECT_THAT(refusal_of([](ObjectBoxOptions& o) { o.farthest = 0; }), HasSubstr("farthest: 0 m"));
  EXPECT_THAT(refusal_of([](ObjectBoxOptions& o) {
                o.least_pixels = std::numeric_limits<double>::quiet_NaN();
              }),
              HasSubstr("least_pixels: nan"));
  EXPECT_THAT(tests::refusal<ArgumentError>([] {
                objects_in_view(tracer(), {std::numeric_limits<float>::infinity(), 0, 0});
              }),
              HasSubstr("not finite"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::capture
