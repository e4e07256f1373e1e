#include "enfilade/continuous/habitat/sensors.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "enfilade/continuous/eyes.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/geometry/habitat_frame.h"
#include "tests/support/lit_rooms.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::continuous::habitat {
namespace EN_UNIT {

using namespace tests;
using ::testing::Each;
using ::testing::HasSubstr;

constexpr double kMillimetre = 1e-3;
constexpr double kQuarterTurn = kPi / 2;

std::shared_ptr<const Scene> shown(mesh::Mesh mesh, Style style = Style::kHabitat) {
  return Scene::photographed(tracer_of(std::move(mesh)), style);
}

Rotation about(Vec3d axis, double angle) {
  const Vec3f v = to_float(std::sin(angle / 2) / length(axis) * axis);
  return {v.x, v.y, v.z, static_cast<float>(std::cos(angle / 2))};
}
Rotation random_rotation(Rng& rng) {
  const Vec3d axis{within(rng, -1, 1), within(rng, -1, 1), within(rng, -1, 1)};
  return about(axis, within(rng, 0, 2 * kPi));
}
// By Rodrigues' formula, from its axis and angle; into our frame.
Vec3d seen_along(const Rotation& r, Vec3d way) {
  const Vec3d v{r.x, r.y, r.z};
  const double sine = length(v);
  if (sine == 0) return from_habitat(way);
  const Vec3d axis = 1 / sine * v;
  const double angle = 2 * std::atan2(sine, double{r.w}), c = std::cos(angle);
  return from_habitat(c * way + std::sin(angle) * cross(axis, way) +
                      (1 - c) * dot(axis, way) * axis);
}
Pose place(Rng& rng, const Rotation& rotation) {
  return {to_float(to_habitat(place_in_room(rng, 0.3))), rotation};
}

struct Shown {
  std::vector<std::uint8_t> colour;
  std::vector<float> depth;
  std::vector<std::uint32_t> instance;
  std::array<int, 3> rgb(std::size_t pixel) const {
    return {colour[4 * pixel], colour[4 * pixel + 1], colour[4 * pixel + 2]};
  }
};
Shown draw(Sensors& sensors, const Sensor& sensor, const Pose& pose) {
  const std::size_t pixels = std::size_t{sensor.width} * sensor.height;
  Shown out{std::vector<std::uint8_t>(4 * pixels), std::vector<float>(pixels),
            std::vector<std::uint32_t>(pixels)};
  sensors.render(sensor, pose, {out.colour, out.depth, out.instance});
  return out;
}

// A wall in front of the origin in Habitat's frame, of the texture's texels as squares of a metre.
mesh::Mesh poster(Vec3f factor, image::Image8 texture) {
  mesh::Mesh mesh;
  const auto wide = static_cast<float>(texture.width), high = static_cast<float>(texture.height);
  mesh.materials.push_back({});
  mesh.materials[0].colour = factor;
  mesh.materials[0].emission = {1, 1, 1};
  mesh.materials[0].mirror = 0.5F;
  add_side(mesh, 0, 1, {-wide / 2, 2, -high / 2}, {wide, 0, 0}, {0, 0, high});
  for (auto& corners : mesh.texture_points) {
    for (mesh::TexturePoint& at : corners) at = {at.u / wide, at.v / high};
  }
  mesh.materials[0].texture = std::move(texture);
  return mesh;
}
image::Image8 texels(std::uint32_t width, std::uint32_t height, std::vector<std::uint8_t> bytes) {
  image::Image8 out(width, height, 3);
  std::ranges::copy(bytes, out.pixels.begin());
  return out;
}

constexpr Sensor kSmall{.width = 48, .height = 40, .horizontal_field_of_view = degrees(79)};
constexpr Sensor kSquare{.width = 64, .height = 64};
constexpr Sensor kAround{.lens = Lens::kEquirectangular, .width = 90, .height = 45};
constexpr Sensor kBulging{.lens = Lens::kFisheye,
                          .width = 64,
                          .height = 60,
                          .double_sphere = {20, 22, 32, 30, -0.27, 0.57}};

// --- colour --------------------------------------------------------------------------------------

TEST(Sensors, FactorsAreDisplayValues) {
  const Pose pose{{0, 1, 0}, {}};
  Sensors display(shown(empty_room())), linear(shown(empty_room(), Style::kPlain));
  for (const Sensor& sensor : {kSmall, kAround, kBulging}) {
    EXPECT_EQ(draw(display, sensor, pose).rgb(999), (std::array{128, 128, 128}));
    EXPECT_EQ(draw(linear, sensor, pose).rgb(999), (std::array{188, 188, 188}));
  }
}

TEST(Sensors, FactorsMultiplyTheBytesOfTextures) {
  Sensors sensors(shown(poster({0.5F, 1, 0.25F}, texels(1, 1, {200, 131, 44}))));
  Sensor sensor = kSquare;
  sensor.horizontal_field_of_view = degrees(10);
  const Shown seen = draw(sensors, sensor, {});
  EXPECT_THAT(seen.rgb(0), (std::array{100, 131, 11})) << "neither light nor mirrors add to it";
  EXPECT_THAT(seen.depth, Each(2.0F));
  EXPECT_THAT(seen.instance, Each(1U));
}

TEST(Sensors, TexturesAreAveragedAsBytes) {
  std::vector<std::uint8_t> checks;
  for (int i = 0; i < 64; ++i) {
    for (int j = 0; j < 64; ++j) checks.insert(checks.end(), 3, (i + j) % 2 == 0 ? 0 : 200);
  }
  Sensors sensors(shown(poster({1, 1, 1}, texels(64, 64, checks))));
  const Sensor sensor{.width = 8, .height = 8};
  Pose pose;
  pose.position.z = 20;
  const Shown seen = draw(sensors, sensor, pose);
  EXPECT_THAT(seen.rgb(8 * 4 + 4), Each(::testing::AllOf(::testing::Ge(98), ::testing::Le(102))))
      << "light would be 146";
}

TEST(Sensors, ColourIsBlackWhereNothingIs) {
  Sensors sensors(shown(poster({1, 1, 1}, texels(1, 1, {9, 9, 9}))));
  for (const Sensor& sensor : {kSmall, kAround, kBulging}) {
    const Shown seen = draw(sensors, sensor, {{0, 0, -4}, {}});
    const std::size_t middle = (sensor.height / 2) * sensor.width + sensor.width / 2;
    EXPECT_EQ(seen.rgb(middle), (std::array{0, 0, 0}));
    EXPECT_EQ(seen.colour[4 * middle + 3], 255);
    EXPECT_EQ(seen.depth[middle], 0);
    EXPECT_EQ(seen.instance[middle], 0U);
  }
}

TEST(Sensors, ColourIsTakenBetweenTexelsOfTheCube) {
  // A left half of black, a right half of 200. One texel of the cube is 8 pixels wide.
  Sensors sensors(shown(poster({1, 1, 1}, texels(2, 1, {0, 0, 0, 200, 200, 200}))));
  Sensor sensor = kAround;
  sensor.cube_size = 12;
  const Shown seen = draw(sensors, sensor, {{0, 0, -1}, {}});
  const std::size_t row = std::size_t{22} * 90;
  std::vector<int> steps;
  for (std::size_t j = 41; j < 49; ++j) steps.push_back(seen.rgb(row + j)[0]);
  EXPECT_TRUE(std::ranges::is_sorted(steps));
  EXPECT_NEAR(steps[3] + steps[4], 200, 2) << "even about the middle";
  EXPECT_GT(steps[3], steps[2]);
}

TEST(Sensors, BacksOfTrianglesAreNotDrawn) {
  const mesh::Mesh wall = poster({1, 1, 1}, texels(1, 1, {9, 9, 9}));
  Sensors habitat(shown(wall)), plain(shown(wall, Style::kPlain));
  Sensor sensor = kSquare;
  sensor.horizontal_field_of_view = degrees(10);
  const Pose front, behind{{0, 0, -4}, about({0, 1, 0}, kPi)};
  EXPECT_THAT(draw(habitat, sensor, front).depth, Each(2.0F));
  EXPECT_THAT(draw(habitat, sensor, behind).depth, Each(0.0F));
  EXPECT_THAT(draw(plain, sensor, behind).depth, Each(2.0F));
}

TEST(Sensors, PlainTwinGivesTheSamePictures) {
  mesh::Mesh mesh = cluttered_room(3000, 8);
  std::vector<std::uint8_t> noise;
  Rng rng(9);
  for (int k = 0; k < 3 * 64 * 32; ++k) {
    noise.push_back(static_cast<std::uint8_t>(within(rng, 0, 255)));
  }
  for (mesh::Material& material : mesh.materials) material.texture = texels(64, 32, noise);
  for (auto& corners : mesh.texture_points) {
    for (mesh::TexturePoint& at : corners) at.u += static_cast<float>(within(rng, 0, 0.5));
  }
  const auto scene = shown(std::move(mesh));
  Eyes fast({scene}, {.threads = 2}), slow({scene}, {.method = Method::kPlain, .threads = 1});
  for (int k = 0; k < 6; ++k) {
    const MeshView view{0, place_in_room(rng), Radians(within(rng, 0, 6)),
                        Radians(within(rng, -1.5, 1.5)), Radians(within(rng, -3, 3))};
    const auto drawn = [&](Eyes& eyes) {
      std::vector<std::byte> bytes(std::size_t{3} * 80 * 60);
      render::Outputs outputs;
      outputs.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, bytes};
      eyes.render({80, 60, degrees(70)}, {&view, 1}, outputs);
      return bytes;
    };
    EXPECT_EQ(drawn(fast), drawn(slow));
  }
}

// --- depth ---------------------------------------------------------------------------------------

TEST(Sensors, DepthAndInstanceOfAPinholeAreExactAtAnyRotation) {
  Rng rng(5);
  Sensors sensors(shown(empty_room()), 1);
  std::size_t other = 0;
  for (int k = 0; k < 40; ++k) {
    const Pose pose = place(rng, random_rotation(rng));
    const Shown seen = draw(sensors, kSmall, pose);
    const double pixel = 2 * std::tan(kSmall.horizontal_field_of_view.value / 2) / kSmall.width;
    for (std::uint32_t p = 0; p < seen.depth.size(); ++p) {
      const Vec3d way{(p % kSmall.width + 0.5 - kSmall.width / 2.0) * pixel,
                      (kSmall.height / 2.0 - (p / kSmall.width + 0.5)) * pixel, -1};
      const Met met =
          side_met(from_habitat(to_double(pose.position)), seen_along(pose.rotation, way));
      ASSERT_NEAR(seen.depth[p], met.distance, kMillimetre) << k << ' ' << p;
      if (seen.instance[p] != met.side + 1) ++other;
    }
  }
  EXPECT_LE(other, 8U) << "a pixel's middle on an edge of the room may round either way";
}

TEST(Sensors, SeesStraightUpAndDown) {
  Sensors sensors(shown(empty_room()));
  const Pose up{{0, 1, 0}, about({1, 0, 0}, kQuarterTurn)};
  EXPECT_NEAR(draw(sensors, kSmall, up).depth[900], kRoomHigh.z - 1, kMillimetre);
  const Pose down{{0, 1, 0}, about({1, 0, 0}, -kQuarterTurn)};
  EXPECT_NEAR(draw(sensors, kSmall, down).depth[900], 1, kMillimetre);
}

TEST(Sensors, ARollTurnsThePicture) {
  Sensors sensors(shown(cluttered_room(3000, 2)), 1);
  const Rotation level = about({0, 1, 0}, 0.7);
  // Its own z axis afterwards, by a quarter counter-clockwise.
  const float half = std::sqrt(0.5F);
  const Rotation rolled{half * level.y, half * level.y, half * level.w, half * level.w};
  const Shown before = draw(sensors, kSquare, {{0, 1, 0}, level});
  const Shown after = draw(sensors, kSquare, {{0, 1, 0}, rolled});
  std::size_t equal = 0;
  for (std::size_t i = 0; i < 64; ++i) {
    for (std::size_t j = 0; j < 64; ++j) {
      const std::size_t there = (63 - j) * 64 + i, here = i * 64 + j;
      if (after.instance[here] == before.instance[there] &&
          std::abs(after.depth[here] - before.depth[there]) < kMillimetre) {
        ++equal;
      }
    }
  }
  EXPECT_GE(equal, 4070U) << "of 4096; pixels on an edge may round either way";
}

// The direction of a pixel in the sensor's frame, and what the room's wall is away along the axis
// of the cube's face that it hits, at the middle of the texel there.
double depth_on_face(const Pose& pose, Vec3d way, std::uint32_t size) {
  std::array<double, 3> v{way.x, way.y, way.z};
  const auto longest = std::ranges::max_element(v, {}, [](double x) { return std::abs(x); });
  const double along = std::abs(*longest);
  for (double& x : v) {
    if (&x == &*longest) {
      x = x > 0 ? 1 : -1;
    } else {
      x = (std::floor((x / along + 1) / 2 * size) + 0.5) / size * 2 - 1;
    }
  }
  return side_met(from_habitat(to_double(pose.position)),
                  seen_along(pose.rotation, {v[0], v[1], v[2]}))
      .distance;
}

TEST(Sensors, EquirectangularDepthIsAlongTheAxisOfTheCubesFace) {
  Rng rng(6);
  Sensors sensors(shown(empty_room()), 1);
  std::size_t far = 0;
  for (int k = 0; k < 20; ++k) {
    const Pose pose = place(rng, random_rotation(rng));
    const Shown seen = draw(sensors, kAround, pose);
    for (std::uint32_t p = 0; p < seen.depth.size(); ++p) {
      const double heading = ((p % 90 + 0.5) / 90 - 0.5) * 2 * kPi;
      const double elevation = (0.5 - (p / 90 + 0.5) / 45) * kPi;
      const Vec3d way{std::cos(elevation) * std::sin(heading), std::sin(elevation),
                      -std::cos(elevation) * std::cos(heading)};
      if (std::abs(seen.depth[p] - depth_on_face(pose, way, 45)) > kMillimetre) ++far;
    }
  }
  EXPECT_LE(far, 20U * 90) << "a pixel on the border of two texels may round either way";
  const Shown level = draw(sensors, kAround, {{0, 1, 0}, {}});
  EXPECT_NEAR(level.depth[22 * 90 + 45 + 10], kRoomHigh.y, kMillimetre) << "40 degrees aside";
}

TEST(Sensors, AFisheyeSeesByTheDoubleSphere) {
  Rng rng(7);
  Sensors sensors(shown(empty_room()), 1);
  const Pose pose = place(rng, random_rotation(rng));
  const Shown seen = draw(sensors, kBulging, pose);
  const DoubleSphere& lens = kBulging.double_sphere;
  // The model as it is defined, from directions to pixels.
  std::size_t met = 0, far = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vec3d way{within(rng, -1, 1), within(rng, -1, 1), within(rng, -0.5, 1)};
    const double first = length(way), z = lens.xi * first + way.z;
    const double second = std::sqrt(way.x * way.x + way.y * way.y + z * z);
    const double scale = 1 / (lens.alpha * second + (1 - lens.alpha) * z);
    const double x = lens.focal_x * way.x * scale + lens.middle_x;
    const double y = lens.focal_y * way.y * scale + lens.middle_y;
    constexpr double kNear = 0.02;  // pixels from a middle
    const double column = std::floor(x), row = std::floor(y);
    if (std::abs(x - column - 0.5) > kNear || std::abs(y - row - 0.5) > kNear) continue;
    if (!(column >= 0 && column < 64 && row >= 0 && row < 60)) continue;
    ++met;
    const float depth = seen.depth[static_cast<std::size_t>(row * 64 + column)];
    if (std::abs(depth - depth_on_face(pose, {way.x, -way.y, -way.z}, 60)) > kMillimetre) ++far;
  }
  EXPECT_GT(met, 10U);
  EXPECT_LE(far, met / 4) << "near the border of two texels";
}

TEST(Sensors, AFisheyeIsBlackBeyondItsField) {
  Sensors sensors(shown(empty_room()));
  Sensor sensor = kBulging;
  sensor.double_sphere.focal_x = sensor.double_sphere.focal_y = 8;
  const Shown seen = draw(sensors, sensor, {{0, 1, 0}, {}});
  EXPECT_EQ(seen.depth[0], 0);
  EXPECT_EQ(seen.rgb(0), (std::array{0, 0, 0}));
  EXPECT_GT(seen.depth[30 * 64 + 32], 0);
}

TEST(Sensors, OnlyWhatLiesBetweenNearAndFarIsDrawn) {
  mesh::Mesh mesh = poster({1, 1, 1}, texels(1, 1, {9, 9, 9}));  // 2 m away, and 5 m
  mesh::Mesh behind = mesh;
  for (Vec3f& p : behind.positions) p = {9 * p.x, p.y + 3, 9 * p.z};
  mesh::append(mesh, behind);
  Sensors sensors(shown(std::move(mesh)));
  for (Sensor sensor : {kSquare, kAround}) {
    const std::size_t middle = (sensor.height / 2) * sensor.width + sensor.width / 2;
    const auto depth = [&](float near, float far) {
      sensor.near = near;
      sensor.far = far;
      return draw(sensors, sensor, {}).depth[middle];
    };
    EXPECT_FLOAT_EQ(depth(0.01F, 1000), 2);
    EXPECT_FLOAT_EQ(depth(1.99F, 2.01F), 2);
    EXPECT_FLOAT_EQ(depth(2.01F, 1000), 5);
    EXPECT_FLOAT_EQ(depth(2.01F, 4.99F), 0);
    EXPECT_FLOAT_EQ(depth(0.01F, 1.99F), 0);
  }
}

TEST(Sensors, NearAndFarCutAlongTheAxisForEachMethod) {
  const auto scene = shown(cluttered_room(3000, 8), Style::kPlain);
  Eyes fast({scene}, {.threads = 2}), slow({scene}, {.method = Method::kPlain, .threads = 1});
  Eyes rays({scene}, {.method = Method::kRays, .threads = 1});
  Rng rng(3);
  constexpr DepthRange kRange{0.7F, 2.5F};
  for (int k = 0; k < 6; ++k) {
    const MeshView view{0, place_in_room(rng), Radians(within(rng, 0, 6)), Radians(0)};
    const auto drawn = [&](Eyes& eyes, const DepthRange& range) {
      std::vector<float> depth(std::size_t{80} * 60);
      render::Outputs outputs;
      outputs.depth =
          render::DepthOutput{render::DepthFormat::kMetresFloat32, render::DepthMeasure::kZ,
                              std::as_writable_bytes(std::span(depth))};
      eyes.render({80, 60, degrees(70)}, {&view, 1}, outputs, range);
      return depth;
    };
    const std::vector<float> whole = drawn(fast, {}), cut = drawn(fast, kRange);
    const std::vector<float> traced = drawn(rays, kRange);
    EXPECT_EQ(cut, drawn(slow, kRange));
    std::size_t others = 0;
    for (std::size_t p = 0; p < cut.size(); ++p) {
      const bool within_range = whole[p] >= kRange.near && whole[p] < kRange.far;
      if (within_range || whole[p] >= kRange.far) {
        EXPECT_EQ(cut[p], within_range ? whole[p] : 0);
      }
      EXPECT_TRUE(cut[p] == 0 || (cut[p] >= kRange.near && cut[p] < kRange.far)) << cut[p];
      if (std::abs(cut[p] - traced[p]) > kMillimetre) ++others;
    }
    EXPECT_LE(others, 10U) << "a pixel's middle on an edge may round either way";
  }
  const MeshView view{0, {1, 1, 1}, {}, {}};
  std::vector<std::uint32_t> instances(64);
  render::Outputs outputs;
  outputs.instances = render::InstanceOutput{instances};
  EXPECT_NO_THROW(fast.render({8, 8, degrees(70)}, {&view, 1}, outputs, {1, 2}));
  for (const DepthRange bad : {DepthRange{-1, 1}, DepthRange{2, 2}, DepthRange{NAN, 2}}) {
    EXPECT_THROW(fast.render({8, 8, degrees(70)}, {&view, 1}, outputs, bad), ArgumentError);
  }
}

// --- labels --------------------------------------------------------------------------------------

// A mesh's objects as the ids of a file. \param placed  where the file has a corner
std::string labels_of(const mesh::Mesh& mesh, Vec3f (*placed)(Vec3f)) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face {}\nproperty list uchar int vertex_indices\nproperty int object_id\n"
      "end_header\n",
      mesh.positions.size(), mesh.triangles.size());
  for (const Vec3f& position : mesh.positions) {
    const Vec3f p = placed(position);
    text += fmt::format("{} {} {} 9 9 9\n", p.x, p.y, p.z);
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    text += fmt::format("3 {} {} {} {}\n", a, b, c, mesh.triangle_object[t] + 1);
  }
  return text;
}

TEST(Sensors, LabelsLieWhereHabitatShowsThem) {
  const mesh::Mesh room = cluttered_room(800, 5);
  Sensors colours(shown(room));
  const TemporaryFolder folder("labels");
  const std::filesystem::path file = folder.path() / "room_semantic.ply";
  const auto same = [&](Upright frame, Vec3f (*placed)(Vec3f)) {
    write_file_atomically(file, labels_of(room, placed));
    Sensors labels(open_labels(file, frame));
    Rng rng(4);
    std::size_t equal = 0, pixels = 0;
    for (const Sensor& sensor : {kSmall, kAround, kBulging}) {
      const Pose pose = place(rng, random_rotation(rng));
      const Shown real = draw(colours, sensor, pose), seen = draw(labels, sensor, pose);
      for (std::size_t p = 0; p < real.instance.size(); ++p, ++pixels) {
        if (seen.instance[p] == real.instance[p]) ++equal;
      }
    }
    return equal == pixels;
  };
  EXPECT_TRUE(same(Upright::kY, [](Vec3f p) { return p; }));
  EXPECT_TRUE(same(Upright::kZ, [](Vec3f p) { return Vec3f{p.x, -p.z, p.y}; }));
  EXPECT_FALSE(same(Upright::kZ, [](Vec3f p) { return p; }));
  EXPECT_THROW(open_labels(folder.path() / "none_semantic.ply", Upright::kY), FileError);
}

// --- files and arguments -------------------------------------------------------------------------

TEST(Sensors, SpansThatAreEmptyAreNotDrawn) {
  Sensors sensors(shown(cluttered_room(500, 3)));
  for (const Sensor& sensor : {kSmall, kAround, kBulging}) {
    const Pose pose{{0, 1, 0}, about({1, 2, 3}, 1)};
    const Shown all = draw(sensors, sensor, pose);
    std::vector<std::uint8_t> colour(all.colour.size());
    sensors.render(sensor, pose, {colour, {}, {}});
    EXPECT_EQ(colour, all.colour);
    std::vector<float> depth(all.depth.size());
    sensors.render(sensor, pose, {{}, depth, {}});
    EXPECT_EQ(depth, all.depth);
  }
}

TEST(Sensors, RefusesWhatIsOutOfRange) {
  Sensors sensors(shown(empty_room()));
  const auto message = [&](Sensor sensor, Pose pose = {}) -> std::string {
    std::vector<float> depth(std::size_t{sensor.width} * sensor.height);
    try {
      sensors.render(sensor, pose, {{}, depth, {}});
    } catch (const ArgumentError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message({.width = 0}), HasSubstr("sensor.width: 0 pixels, not 1 .. 8192"));
  EXPECT_THAT(message({.cube_size = 9000}), HasSubstr("sensor.cube_size: 9000 pixels"));
  EXPECT_THAT(message({.horizontal_field_of_view = degrees(180)}), HasSubstr("not in (0, pi)"));
  EXPECT_THAT(message({.near = 0}), HasSubstr("near 0 and far 1000 metres, not 0 < near < far"));
  EXPECT_THAT(message({.near = 2, .far = 1}), HasSubstr("near 2 and far 1"));
  EXPECT_THAT(message({.lens = Lens::kFisheye}), HasSubstr("focal: (0, 0) pixels, not above 0"));
  Sensor fisheye = kBulging;
  fisheye.double_sphere.alpha = 1.5;
  EXPECT_THAT(message(fisheye), HasSubstr("alpha: 1.5, not in [0, 1]"));
  EXPECT_THAT(message(kSmall, {{}, {0, 0, 0, 2}}), HasSubstr("pose.rotation: (0, 0, 0, 2)"));
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(message(kSmall, {{kNone, 0, 0}, {}}), HasSubstr("not finite"));
  std::vector<float> few(3);
  EXPECT_THROW(sensors.render(kSmall, {}, {{}, few, {}}), ArgumentError);
  EXPECT_THROW(Sensors(nullptr), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous::habitat
