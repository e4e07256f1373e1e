#include "enfilade/continuous/eyes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/image/image.h"
#include "enfilade/render/renderer.h"
#include "tests/support/lit_rooms.h"

namespace enfilade::continuous {
namespace EN_UNIT {

using namespace tests;
using ::testing::HasSubstr;

constexpr double kMillimetre = 1e-3;

std::shared_ptr<const Scene> room_scene() {
  static const auto kScene = Scene::photographed(tracer_of(empty_room()));
  return kScene;
}
std::shared_ptr<const Scene> clutter_scene() {
  static const auto kScene = Scene::photographed(tracer_of(cluttered_room(5000, 3)));
  return kScene;
}

MeshView random_view(Rng& rng, double margin = 0.05) {
  return {0, place_in_room(rng, margin), Radians(within(rng, 0, 2 * kPi)),
          Radians(within(rng, -kPi / 2, kPi / 2))};
}

// All four layers of some views; depth in metres along the ray or the axis.
struct Drawn {
  std::vector<std::byte> colour;
  std::vector<float> depth;
  std::vector<std::uint16_t> classes;
  std::vector<std::uint32_t> instances;

  explicit Drawn(std::size_t pixels)
      : colour(3 * pixels), depth(pixels), classes(pixels), instances(pixels) {}
  render::Outputs outputs(render::DepthMeasure measure = render::DepthMeasure::kZ) {
    render::Outputs out;
    out.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, colour};
    out.depth = render::DepthOutput{render::DepthFormat::kMetresFloat32, measure,
                                    std::as_writable_bytes(std::span(depth))};
    out.classes = render::ClassOutput{render::ClassFormat::kUint16,
                                      std::as_writable_bytes(std::span(classes))};
    out.instances = render::InstanceOutput{instances};
    return out;
  }
  friend bool operator==(const Drawn&, const Drawn&) = default;
};

Drawn draw(Eyes& eyes, const Camera& camera, std::span<const MeshView> views) {
  Drawn drawn(views.size() * camera.width * camera.height);
  eyes.render(camera, views, drawn.outputs());
  return drawn;
}

// --- what pixels see -----------------------------------------------------------------------------

TEST(Eyes, DepthOfARoomIsExactAtAnyPose) {
  Rng rng(1);
  for (const Method method : {Method::kRaster, Method::kRays, Method::kPlain}) {
    Eyes eyes({room_scene()}, {method, 1});
    for (const Camera& camera : {Camera{64, 64, degrees(90)}, Camera{101, 37, degrees(60)},
                                 Camera{33, 90, degrees(140)}}) {
      for (int k = 0; k < 12; ++k) {
        const MeshView view = random_view(rng);
        const Drawn drawn = draw(eyes, camera, {&view, 1});
        const PixelRays rays = pixel_rays(camera, world_from_camera(view.heading, view.elevation));
        for (std::uint32_t i = 0; i < camera.height; ++i) {
          for (std::uint32_t j = 0; j < camera.width; ++j) {
            const Met met = side_met(view.eye, rays.at(i, j));
            ASSERT_NEAR(drawn.depth[i * camera.width + j], met.distance, kMillimetre)
                << enum_name(method) << ' ' << i << ' ' << j;
          }
        }
      }
    }
  }
}

TEST(Eyes, ClassesAndInstancesAreThoseOfTheSide) {
  Rng rng(2);
  const Camera camera{80, 60, degrees(75)};
  for (const Method method : {Method::kRaster, Method::kRays}) {
    Eyes eyes({room_scene()}, {method, 1});
    std::size_t wrong = 0;
    for (int k = 0; k < 20; ++k) {
      const MeshView view = random_view(rng);
      const Drawn drawn = draw(eyes, camera, {&view, 1});
      const PixelRays rays = pixel_rays(camera, world_from_camera(view.heading, view.elevation));
      for (std::size_t p = 0; p < drawn.classes.size(); ++p) {
        const auto i = static_cast<double>(p / camera.width),
                   j = static_cast<double>(p % camera.width);
        const std::size_t side = side_met(view.eye, rays.at(i, j)).side;
        if (drawn.classes[p] != 10 + side || drawn.instances[p] != side + 1) ++wrong;
      }
    }
    EXPECT_LE(wrong, 4U) << "a pixel's middle on an edge of the room may round either way";
  }
}

TEST(Eyes, EquirectangularDepthIsAlongTheRay) {
  Rng rng(3);
  constexpr std::uint32_t kWidth = 90, kHeight = 41;
  Eyes eyes({room_scene()}, {Method::kRaster, 2});
  for (int k = 0; k < 10; ++k) {
    const MeshView view = random_view(rng);
    Drawn drawn(kWidth * kHeight);
    eyes.render_equirectangular(kWidth, kHeight, {&view, 1}, drawn.outputs());
    for (std::uint32_t i = 0; i < kHeight; ++i) {
      for (std::uint32_t j = 0; j < kWidth; ++j) {
        const double h = view.heading.value + ((j + 0.5) / kWidth - 0.5) * 2 * kPi;
        const double e = (0.5 - (i + 0.5) / kHeight) * kPi;
        const Vec3d way{std::cos(e) * std::sin(h), std::cos(e) * std::cos(h), std::sin(e)};
        const Met met = side_met(view.eye, way);
        ASSERT_NEAR(drawn.depth[i * kWidth + j], met.distance, kMillimetre) << i << ' ' << j;
      }
    }
  }
}

TEST(Eyes, DepthAlongTheRayAndInQuarterMillimetres) {
  Rng rng(4);
  const MeshView view = random_view(rng);
  const Camera camera{48, 48, degrees(90)};
  Eyes eyes({room_scene()});
  const Drawn z = draw(eyes, camera, {&view, 1});
  Drawn ray(z.depth.size());
  eyes.render(camera, {&view, 1}, ray.outputs(render::DepthMeasure::kRay));
  std::vector<std::uint16_t> units(z.depth.size());
  render::Outputs outputs;
  outputs.depth =
      render::DepthOutput{render::DepthFormat::kQuarterMillimetresUint16, render::DepthMeasure::kZ,
                          std::as_writable_bytes(std::span(units))};
  eyes.render(camera, {&view, 1}, outputs);
  const PixelRays rays = pixel_rays(camera, Mat3d{});
  for (std::uint32_t i = 0; i < camera.height; ++i) {
    for (std::uint32_t j = 0; j < camera.width; ++j) {
      const std::size_t p = i * camera.width + j;
      EXPECT_NEAR(ray.depth[p], z.depth[p] * length(rays.at(i, j)), 1e-5);
      EXPECT_NEAR(units[p], z.depth[p] * image::kDepthUnitsPerMetre, 0.51);
    }
  }
}

TEST(Eyes, MethodsAgreeInClutter) {
  Rng rng(5);
  const Camera camera{128, 96, degrees(90)};
  Eyes raster({clutter_scene()}, {Method::kRaster, 1}), rays({clutter_scene()}, {Method::kRays, 1});
  std::size_t pixels = 0, differ = 0;
  for (int k = 0; k < 20; ++k) {
    const MeshView view = random_view(rng);
    const Drawn a = draw(raster, camera, {&view, 1}), b = draw(rays, camera, {&view, 1});
    for (std::size_t p = 0; p < a.depth.size(); ++p) {
      ++pixels;
      if (std::abs(a.depth[p] - b.depth[p]) > 1e-4 * a.depth[p] + 1e-5) ++differ;
    }
  }
  // Pixels whose middle is on an edge, where rounding decides.
  EXPECT_LE(static_cast<double>(differ), 2e-4 * static_cast<double>(pixels));
}

TEST(Eyes, PlainTwinGivesTheSameBytes) {
  Rng rng(6);
  for (const Camera& camera : {Camera{96, 96, degrees(90)}, Camera{75, 50, degrees(50)}}) {
    Eyes fast({clutter_scene()}, {Method::kRaster, 1}),
        plain({clutter_scene()}, {Method::kPlain, 1});
    for (int k = 0; k < 8; ++k) {
      const MeshView view = random_view(rng);
      EXPECT_TRUE(draw(fast, camera, {&view, 1}) == draw(plain, camera, {&view, 1})) << k;
    }
  }
}

TEST(Eyes, SameViewSameBytesInAnyBatchWithAnyThreads) {
  Rng rng(7);
  const Camera camera{72, 70, degrees(90)};
  std::vector<MeshView> views;
  for (int k = 0; k < 9; ++k) views.push_back(random_view(rng));
  for (std::size_t k = 0; k < views.size(); ++k) views[k].building = k % 2;
  const std::vector<std::shared_ptr<const Scene>> both{room_scene(), clutter_scene()};
  for (const Method method : {Method::kRaster, Method::kRays}) {
    Eyes one(both, {method, 1});
    const Drawn all = draw(one, camera, views);
    for (const int threads : {2, 3, 8}) {
      Eyes several(both, {method, threads});
      EXPECT_TRUE(draw(several, camera, views) == all) << threads;
      const std::size_t pixels = camera.width * camera.height;
      for (std::size_t k = 0; k < views.size(); ++k) {
        const Drawn single = draw(several, camera, {&views[k], 1});
        EXPECT_TRUE(
            std::ranges::equal(single.depth, std::span(all.depth).subspan(k * pixels, pixels)));
        EXPECT_TRUE(std::ranges::equal(single.colour,
                                       std::span(all.colour).subspan(3 * k * pixels, 3 * pixels)));
      }
    }
  }
}

// --- colours -------------------------------------------------------------------------------------

image::Image8 one_colour(std::uint32_t size, std::array<std::uint8_t, 3> rgb) {
  image::Image8 picture(size, size, 3);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] = rgb[i % 3];
  return picture;
}

TEST(Eyes, PhotographedColoursAreTheTexture) {
  mesh::Mesh mesh = empty_room();
  mesh.materials[0].colour = {1, 1, 1};
  for (const std::array<std::uint8_t, 3> rgb :
       {std::array<std::uint8_t, 3>{0, 1, 2}, {37, 128, 200}, {253, 254, 255}, {90, 17, 3}}) {
    mesh.materials[0].texture = one_colour(32, rgb);
    Eyes eyes({Scene::photographed(tracer_of(mesh))});
    Rng rng(8);
    const MeshView view = random_view(rng);
    const Drawn drawn = draw(eyes, {32, 32, degrees(90)}, {&view, 1});
    for (std::size_t p = 0; p < drawn.colour.size(); ++p) {
      ASSERT_EQ(std::to_integer<int>(drawn.colour[p]), rgb[p % 3]) << p;
    }
  }
}

TEST(Eyes, FarTexturesAreAveraged) {
  // Black and white stripes of 1 mm are grey from 1 m on, wherever one stands.
  mesh::Mesh mesh = empty_room();
  mesh.materials[0].colour = {1, 1, 1};
  mesh.materials[0].texture = image::Image8(1024, 4, 3);
  auto& pixels = mesh.materials[0].texture.pixels;
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = i / 3 % 2 == 0 ? 255 : 0;
  Eyes eyes({Scene::photographed(tracer_of(mesh))});
  Rng rng(9);
  for (int k = 0; k < 5; ++k) {
    const MeshView view{0, place_in_room(rng, 1), Radians(within(rng, 0, 6)), Radians(0)};
    const Drawn drawn = draw(eyes, {40, 40, degrees(90)}, {&view, 1});
    for (const std::byte value : drawn.colour) {
      ASSERT_NEAR(std::to_integer<int>(value), 188, 4);  // sRGB of 0.5
    }
  }
}

TEST(Eyes, FormatsHaveTheSameColours) {
  Rng rng(10);
  const MeshView view = random_view(rng);
  const Camera camera{50, 30, degrees(80)};
  Eyes eyes({clutter_scene()});
  const Drawn rgb = draw(eyes, camera, {&view, 1});
  const std::size_t pixels = rgb.depth.size();
  std::vector<float> planes(3 * pixels);
  render::Outputs outputs;
  outputs.colour = render::ColourOutput{
      render::ColourFormat::kPlanarFloat32, {}, std::as_writable_bytes(std::span(planes))};
  eyes.render(camera, {&view, 1}, outputs);
  for (std::size_t p = 0; p < pixels; ++p) {
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_NEAR(planes[c * pixels + p], std::to_integer<int>(rgb.colour[3 * p + c]) / 255.0,
                  1e-6);
    }
  }
  std::vector<std::uint8_t> bytes(pixels);
  render::Outputs small;
  small.classes =
      render::ClassOutput{render::ClassFormat::kUint8, std::as_writable_bytes(std::span(bytes))};
  eyes.render(camera, {&view, 1}, small);
  EXPECT_TRUE(std::ranges::equal(bytes, rgb.classes));
}

TEST(Eyes, HolesInTexturesAreSeenThrough) {
  mesh::Mesh mesh = empty_room();
  const std::uint32_t leaves = add_material(mesh, {1, 1, 1});
  image::Image8 picture(16, 16, 4);
  for (std::size_t i = 0; i < 256; ++i) {
    picture.pixels[4 * i + 3] = i % 16 < 8 ? 255 : 0;  // the right half is a hole
  }
  mesh.materials[leaves].texture = std::move(picture);
  mesh.materials[leaves].cutout = 0.5F;
  add_side(mesh, leaves, 20, {1, -1, 0.5F}, {0, 1, 0}, {0, 0, 1});
  const auto scene = Scene::photographed(tracer_of(mesh));
  const MeshView view{0, {-1, -0.5, 1}, Radians(kPi / 2), Radians(0)};
  const Camera camera{65, 65, degrees(60)};
  Eyes raster({scene}, {Method::kRaster, 1}), rays({scene}, {Method::kRays, 1});
  Eyes plain({scene}, {Method::kPlain, 1});
  const Drawn a = draw(raster, camera, {&view, 1}), b = draw(rays, camera, {&view, 1});
  EXPECT_TRUE(a == draw(plain, camera, {&view, 1}));
  // u runs from y = -1 (right of the view's middle) to y = 0: the hole is on the left.
  EXPECT_EQ(a.classes[32 * 65 + 27], 11);
  EXPECT_EQ(a.classes[32 * 65 + 37], 20);
  std::size_t differ = 0;
  for (std::size_t p = 0; p < a.classes.size(); ++p) differ += a.classes[p] != b.classes[p] ? 1 : 0;
  EXPECT_LE(differ, 40U) << "the rim of the hole is rounded differently";
}

// --- odd places ----------------------------------------------------------------------------------

TEST(Eyes, NothingIsSeenWhereNothingIs) {
  Eyes eyes({room_scene()});
  const MeshView away{0, {20, 0, 1}, Radians(kPi / 2), Radians(0)};
  const Drawn drawn = draw(eyes, {40, 40, degrees(90)}, {&away, 1});
  for (std::size_t p = 0; p < drawn.depth.size(); ++p) {
    ASSERT_EQ(drawn.depth[p], 0);
    ASSERT_EQ(drawn.classes[p], 0);
    ASSERT_EQ(drawn.instances[p], 0U);
    ASSERT_EQ(drawn.colour[3 * p], std::byte{0});
  }
}

TEST(Eyes, OddPlacesGiveWhatTheMeshHas) {
  // From outside, from exactly on a wall, from in a corner, from far away.
  Eyes raster({room_scene()}, {Method::kRaster, 1}), rays({room_scene()}, {Method::kRays, 1});
  const Camera camera{64, 64, degrees(90)};
  const MeshView outside{0, {-9, 0.5, 1.2}, Radians(kPi / 2), Radians(0)};
  const Drawn a = draw(raster, camera, {&outside, 1}), b = draw(rays, camera, {&outside, 1});
  std::size_t seen = 0;
  for (std::size_t p = 0; p < a.depth.size(); ++p) {
    EXPECT_NEAR(a.depth[p], b.depth[p], kMillimetre) << p;
    if (a.depth[p] > 0) ++seen;
  }
  EXPECT_GT(seen, 100U);
  for (const Vec3d eye : {Vec3d{kRoomLow.x, 0, 1}, Vec3d{kRoomLow.x, kRoomLow.y, kRoomLow.z},
                          Vec3d{1e7, -1e7, 1e7}, Vec3d{0, 0, 2.75}}) {
    for (double heading = 0; heading < 6.3; heading += 0.7) {
      const MeshView view{0, eye, Radians(heading), Radians(-0.3)};
      for (const float depth : draw(raster, camera, {&view, 1}).depth) {
        ASSERT_TRUE(std::isfinite(depth) && depth >= 0);
      }
    }
  }
}

TEST(Eyes, NothingIsLeftFromAnotherBuilding) {
  // Sizes that fill no tile: what lies beyond the edge must not be looked up in the next building.
  Rng rng(13);
  for (const Method method : {Method::kRaster, Method::kRays}) {
    Eyes both({room_scene(), clutter_scene()}, {method, 1}), one({room_scene()}, {method, 1});
    const Camera camera{61, 43, degrees(90)};
    MeshView view = random_view(rng);
    const Drawn alone = draw(one, camera, {&view, 1});
    view.building = 1;
    draw(both, camera, {&view, 1});
    view.building = 0;
    EXPECT_TRUE(draw(both, camera, {&view, 1}) == alone) << enum_name(method);
    Drawn sphere(53 * 27), sphere_alone(53 * 27);
    one.render_equirectangular(53, 27, {&view, 1}, sphere_alone.outputs());
    view.building = 1;
    both.render_equirectangular(53, 27, {&view, 1}, sphere.outputs());
    view.building = 0;
    both.render_equirectangular(53, 27, {&view, 1}, sphere.outputs());
    EXPECT_TRUE(sphere == sphere_alone) << enum_name(method);
  }
}

TEST(Eyes, NoViewsAreNoWork) {
  Eyes eyes({room_scene()});
  Drawn drawn(0);
  eyes.render({64, 64, degrees(90)}, {}, drawn.outputs());
  eyes.render({64, 64, degrees(90)}, {}, {});
  eyes.render_equirectangular(64, 32, {}, drawn.outputs());
}

// --- mistakes ------------------------------------------------------------------------------------

std::string message(Eyes& eyes, const Camera& camera, const MeshView& view) {
  const std::size_t pixels =
      std::size_t{std::min(camera.width, 100U)} * std::min(camera.height, 100U);
  Drawn drawn(pixels);
  try {
    eyes.render(camera, {&view, 1}, drawn.outputs());
  } catch (const ArgumentError& error) {
    return error.what();
  }
  return "";
}

TEST(Eyes, MistakesAreNamed) {
  Eyes eyes({room_scene()});
  const Camera good{8, 8, degrees(90)};
  const MeshView here{0, {0, 0, 1}, Radians(0), Radians(0)};
  EXPECT_EQ(message(eyes, good, here), "");
  const auto with = [&](auto change) {
    MeshView view = here;
    change(view);
    return message(eyes, good, view);
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(with([](MeshView& v) { v.building = 1; }), HasSubstr("views[0].building: 1"));
  EXPECT_THAT(with([](MeshView& v) { v.eye.y = kNan; }), HasSubstr("views[0].eye"));
  EXPECT_THAT(with([](MeshView& v) { v.eye.z = 1e300; }), HasSubstr("views[0].eye"));
  EXPECT_THAT(with([](MeshView& v) { v.heading = Radians(kNan); }), HasSubstr("heading"));
  EXPECT_THAT(with([](MeshView& v) { v.elevation = Radians(1.6); }), HasSubstr("elevation: 1.6"));
  EXPECT_THAT(message(eyes, {0, 8, degrees(90)}, here), HasSubstr("camera size"));
  EXPECT_THAT(message(eyes, {8, 8, Radians(kPi)}, here), HasSubstr("field of view"));
  EXPECT_THAT(message(eyes, {100000, 1, degrees(90)}, here), HasSubstr("100000"));
  Drawn drawn(63);
  EXPECT_THROW(eyes.render(good, {&here, 1}, drawn.outputs()), ArgumentError);
  EXPECT_THROW(Eyes({}), ArgumentError);
  EXPECT_THROW(Eyes({nullptr}), ArgumentError);
  EXPECT_THROW(Eyes({room_scene()}, {Method::kRaster, -1}), ArgumentError);
  EXPECT_THROW(Scene::photographed(nullptr), ArgumentError);
}

TEST(Eyes, MethodsHaveNames) {
  for (const Method method : {Method::kRaster, Method::kRays, Method::kPlain}) {
    EXPECT_EQ(find_enum<Method>(enum_name(method)), method);
  }
  EXPECT_FALSE(find_enum<Method>("gl"));
  EXPECT_THAT(Eyes({room_scene()}, {Method::kRaster, 3}).description(), HasSubstr("3 threads"));
}

TEST(EyesCache, OpensABuildingOnceAndKeepsTheLast) {
  std::string opened;
  EyesCache cache(
      [&opened](const std::string& scan) -> std::shared_ptr<const Scene> {
        opened += scan;
        return scan == "x" ? nullptr : room_scene();
      },
      1, 2);
  Eyes& a = cache.of("a");
  EXPECT_EQ(&cache.of("a"), &a);
  cache.of("b");
  cache.of("a");
  EXPECT_EQ(opened, "ab");
  cache.of("c");  // b goes, as a was used after it
  EXPECT_EQ(&cache.of("a"), &a);
  cache.of("b");
  EXPECT_EQ(opened, "abcb");
  EXPECT_THROW(cache.of("x"), ArgumentError);
  cache.of("b");
  cache.of("a");  // went before x was loaded
  EXPECT_EQ(opened, "abcbxa");
  // a was used last; b is in use, so it stays however few are kept.
  cache.keep(0, std::set<std::string>{"b"});
  cache.of("b");
  cache.keep(1, std::set<std::string>{});
  cache.of("b");
  EXPECT_EQ(opened, "abcbxa");
  cache.of("a");
  EXPECT_EQ(opened, "abcbxaa");
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous
