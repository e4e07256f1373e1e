#include <epoxy/egl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <random>
#include <thread>

#include "enfilade/core/errors.h"
#include "enfilade/render/detail/layers.h"
#include "enfilade/render/devices.h"
#include "enfilade/render/gl/pieces.h"
#include "tests/support/refusal.h"

namespace enfilade::render {
namespace EN_UNIT {

using scan::Layer;
using ::testing::HasSubstr;

using Texels = std::array<std::uint8_t, 3>;

scan::Connectivity viewpoints(std::size_t count) {
  scan::Connectivity c{"house", "<memory>", {}};
  for (std::size_t k = 0; k < count; ++k) {
    scan::ConnectivityEntry entry;
    entry.id = "v" + std::to_string(k);
    // Upright: panorama x, y (down), z (forward) are world x, -z, y.
    entry.pose = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1};
    c.entries.push_back(entry);
  }
  return c;
}

// Calls colour(face, s, t) for each texel's middle.
template <class Colour>
image::CubeMap<std::uint8_t> painted(std::uint32_t size, const Colour& colour) {
  image::CubeMap<std::uint8_t> faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    faces[k] = image::Image8(size, size, 3);
    for (std::uint32_t y = 0; y < size; ++y) {
      for (std::uint32_t x = 0; x < size; ++x) {
        const Texels rgb = colour(cube_face(k), (x + 0.5) / size, (y + 0.5) / size);
        std::ranges::copy(rgb, faces[k].at(x, y));
      }
    }
  }
  return faces;
}

Texels colour_of(Vec3d d) {
  const double length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
  const auto level = [&](double part) {
    return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * part / length));
  };
  return {level(d.x), level(d.y), level(d.z)};
}

image::CubeMap<std::uint8_t> plain(std::uint32_t size, Texels colour) {
  return painted(size, [&](CubeFace, double, double) { return colour; });
}

// Noise in every layer: the worst that filtering can meet.
scan::Panorama noise(std::uint32_t size, std::uint32_t seed) {
  std::mt19937 random(seed);
  scan::Panorama p = scan::make_panorama(size);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    for (auto& v : p.colour[k].pixels) v = static_cast<std::uint8_t>(random());
    for (auto& v : p.depth[k].pixels) v = static_cast<std::uint16_t>(random());
    for (auto& v : p.classes[k].pixels) v = static_cast<std::uint16_t>(random());
    for (auto& v : p.instances[k].pixels) v = static_cast<std::uint32_t>(random());
  }
  return p;
}

std::shared_ptr<FaceCache> cache_of(std::vector<scan::Panorama> panoramas,
                                    std::size_t bytes = std::size_t{64} << 20) {
  const std::size_t count = panoramas.size();
  const auto source =
      std::make_shared<scan::MemoryPanoramas>(viewpoints(count), std::move(panoramas));
  FaceCacheConfig config;
  config.bytes = bytes;
  return std::make_shared<FaceCache>(scan::PanoramaSet::of({source}), config);
}

std::unique_ptr<Renderer> gl_renderer(std::shared_ptr<FaceCache> faces, Legacy legacy = {}) {
  RendererConfig config;
  config.backend = Backend::kGl;
  config.legacy = legacy;
  return detail::make_gl_renderer(std::move(faces), config);
}

std::vector<View> random_views(std::size_t count, std::size_t panoramas, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<View> views;
  for (std::size_t k = 0; k < count; ++k) {
    views.push_back({ScanIndex(0), ViewpointIndex(k % panoramas), Radians(unit(random) * 2 * kPi),
                     Radians((unit(random) - 0.5) * kPi)});
  }
  return views;
}

// All outputs of a batch, native formats.
struct Pictures {
  std::vector<std::uint8_t> rgb;
  std::vector<std::uint16_t> depth, classes;
  std::vector<std::uint32_t> instances;
  friend bool operator==(const Pictures&, const Pictures&) = default;
};

template <class T>
std::span<std::byte> bytes(std::vector<T>& values) {
  return std::as_writable_bytes(std::span(values));
}

std::vector<std::uint8_t> draw_rgb(Renderer& renderer, const Camera& camera,
                                   std::span<const View> views) {
  std::vector<std::uint8_t> rgb(views.size() * camera.width * camera.height * 3);
  Outputs outputs;
  outputs.colour = ColourOutput{ColourFormat::kRgb8, {}, bytes(rgb)};
  renderer.render(camera, views, outputs);
  return rgb;
}

Pictures draw(Renderer& renderer, const Camera& camera, std::span<const View> views) {
  const std::size_t n = views.size() * camera.width * camera.height;
  Pictures p{std::vector<std::uint8_t>(3 * n), std::vector<std::uint16_t>(n),
             std::vector<std::uint16_t>(n), std::vector<std::uint32_t>(n)};
  Outputs outputs;
  outputs.colour = ColourOutput{ColourFormat::kRgb8, {}, bytes(p.rgb)};
  outputs.depth =
      DepthOutput{DepthFormat::kQuarterMillimetresUint16, DepthMeasure::kZ, bytes(p.depth)};
  outputs.classes = ClassOutput{ClassFormat::kUint16, bytes(p.classes)};
  outputs.instances = InstanceOutput{p.instances};
  renderer.render(camera, views, outputs);
  return p;
}

/// Skips, with EGL's words, where no device works.
class Gl : public ::testing::Test {
 protected:
  void SetUp() override {
    static const std::string kWhyNot = why_not();
    if (!kWhyNot.empty()) GTEST_SKIP() << kWhyNot;
  }

 private:
  static std::string why_not() {
    std::string faults = "no OpenGL device:";
    for (const GlDevice& device : gl_devices()) {
      if (device.works) return "";
      faults += " " + device.error + ";";
    }
    return faults;
  }
};

TEST(GlPieces, CoverThePictureOnceAndOverlapByTheMargin) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  constexpr double kMargin = 0.25;
  for (int k = 0; k < 1000; ++k) {
    const Camera camera{64, 48, degrees(10 + 160 * unit(random))};
    const PixelRays rays = pixel_rays(
        camera, world_from_camera(Radians(7 * unit(random)), Radians(unit(random) * 3 - 1.5)));
    double exact = 0, wide = 0;
    for (std::size_t face = 0; face < kCubeFaces; ++face) {
      const gl::FaceForms forms = gl::face_forms(camera, rays, cube_face(face));
      const auto area = [&](double margin) {
        const gl::FacePiece piece = gl::piece_of(camera, forms, margin);
        const auto c = piece.corners();
        double twice = 0;
        for (std::size_t i = 0; i < c.size(); ++i) {
          const auto& next = c[(i + 1) % c.size()];
          twice += c[i].x * next.y - c[i].y * next.x;
        }
        return twice / 2;
      };
      exact += area(0);
      wide += area(kMargin);
    }
    // Rounding of doubles, 1e-16 of each of some 30 products of up to 64 * 48.
    ASSERT_NEAR(exact, 64 * 48, 1e-9);
    ASSERT_GE(wide, exact);
  }
}

TEST_F(Gl, DirectionsComeBackAsTheRaysOfTheCamera) {
  constexpr std::uint32_t kSize = 128;
  scan::Panorama panorama;
  panorama.colour = painted(kSize, [](CubeFace face, double s, double t) {
    return colour_of(cube_direction(face, s, t));
  });
  const auto renderer = gl_renderer(cache_of({panorama}));
  const Mat3d panorama_from_world{{1, 0, 0, 0, 0, -1, 0, 1, 0}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int k = 0; k < 300; ++k) {
    const Camera camera{40, 30, degrees(5 + 140 * unit(random))};
    std::vector<View> view = random_views(1, 1, static_cast<std::uint32_t>(k));
    if (k % 10 == 0) view[0].elevation = Radians(k % 20 == 0 ? kPi / 2 : -kPi / 2);
    const auto rgb = draw_rgb(*renderer, camera, view);
    const PixelRays rays = pixel_rays(
        camera, panorama_from_world * world_from_camera(view[0].heading, view[0].elevation));
    for (std::size_t i = 0; i < camera.height; ++i) {
      for (std::size_t j = 0; j < camera.width; ++j) {
        const Texels expected = colour_of(rays.at(static_cast<double>(i), static_cast<double>(j)));
        for (std::size_t c = 0; c < 3; ++c) {
          // Texels are 2 levels apart. Where faces meet, a border texel is up to half a texel off
          // along the edge (1 level, at half weight); rounding of texels, weights and result.
          ASSERT_NEAR(rgb[(i * camera.width + j) * 3 + c], expected[c], 2)
              << "view " << k << ", row " << i << ", column " << j << ", channel " << c;
        }
      }
    }
  }
}

TEST_F(Gl, ConstantColourStaysConstant) {
  scan::Panorama red, blue;
  red.colour = plain(16, {201, 3, 77});
  blue.colour = plain(16, {5, 60, 255});
  const auto renderer = gl_renderer(cache_of({red, blue}));
  const auto cameras = {Camera{1, 1, degrees(60)},    Camera{33, 17, degrees(170)},
                        Camera{7, 301, degrees(100)}, Camera{64, 48, degrees(1)},
                        Camera{500, 3, degrees(30)},  Camera{96, 96, degrees(90)}};
  for (const Camera& camera : cameras) {
    auto views = random_views(64, 2, camera.width);
    // Along seams and corners too.
    for (std::size_t k = 0; k < 32; ++k) views[k].heading = degrees(45.0 * static_cast<double>(k));
    for (std::size_t k = 0; k < 16; ++k) views[k].elevation = Radians(0);
    // Twice, with the panoramas exchanged: a pixel that is left out shows the other's colour.
    for (const std::size_t turn : {0U, 1U}) {
      for (std::size_t k = 0; k < 64; ++k) views[k].viewpoint = ViewpointIndex((k + turn) % 2);
      const auto rgb = draw_rgb(*renderer, camera, views);
      const std::size_t pixels = std::size_t{camera.width} * camera.height;
      for (std::size_t k = 0; k < rgb.size() / 3; ++k) {
        const bool is_red = (k / pixels + turn) % 2 == 0;
        const Texels expected = is_red ? Texels{201, 3, 77} : Texels{5, 60, 255};
        ASSERT_TRUE(
            std::equal(expected.begin(), expected.end(), rgb.begin() + 3 * std::ptrdiff_t(k)))
            << camera.width << " x " << camera.height << ", pixel " << k;
      }
    }
  }
}

// Mesa's llvmpipe interpolates between texels across and then down. It rounds both times where it
// has pmulhrsw (SSSE3), and cuts off elsewhere: lp_build_lerp_simple() of Mesa 22.3. That is up to
// a level lower.
bool cuts_off(const Renderer& renderer) {
#if defined(__x86_64__)
  static_cast<void>(renderer);
  return false;
#else
  return renderer.description().find("llvmpipe") != std::string::npos;
#endif
}

TEST_F(Gl, AgreesWithTheScalarRenderer) {
  const auto cache = cache_of({noise(64, 1), noise(64, 2), noise(64, 3)});
  const auto gl = gl_renderer(cache);
  RendererConfig config;
  config.backend = Backend::kCpuScalar;
  const auto cpu = make_renderer(cache, config);
  const Camera camera{160, 120, degrees(75)};
  const auto views = random_views(60, 3, 11);
  const Pictures a = draw(*gl, camera, views), b = draw(*cpu, camera, views);
  const auto differing = [](const auto& x, const auto& y, int allowed) {
    std::size_t count = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
      count +=
          std::abs(static_cast<std::int64_t>(x[k]) - static_cast<std::int64_t>(y[k])) > allowed;
    }
    return static_cast<double>(count) / static_cast<double>(x.size());
  };
  // Noise: hardware's 8-bit weights are worth up to 1/256 of 255 levels in each direction, and a
  // texel's edge that falls on another side of a pixel by float rounding gives any other value.
  EXPECT_LE(differing(a.rgb, b.rgb, cuts_off(*gl) ? 2 : 1), 1e-3);
  EXPECT_LE(differing(a.rgb, b.rgb, 2), 1e-4);
  EXPECT_LE(differing(a.depth, b.depth, 0), 1e-3);
  EXPECT_LE(differing(a.classes, b.classes, 0), 1e-3);
  EXPECT_LE(differing(a.instances, b.instances, 0), 1e-3);
}

TEST_F(Gl, AViewHasTheSameBytesInAnyBatch) {
  const auto cache = cache_of({noise(32, 1), noise(32, 2)});
  const Camera camera{320, 200, degrees(80)};
  const auto views = random_views(70, 2, 5);
  const Pictures all = draw(*gl_renderer(cache), camera, views);
  const auto renderer = gl_renderer(cache);
  Pictures pieces;
  for (std::size_t first = 0, size = 1; first < views.size(); first += size, ++size) {
    size = std::min(size, views.size() - first);
    const Pictures part = draw(*renderer, camera, std::span(views).subspan(first, size));
    pieces.rgb.insert(pieces.rgb.end(), part.rgb.begin(), part.rgb.end());
    pieces.depth.insert(pieces.depth.end(), part.depth.begin(), part.depth.end());
    pieces.classes.insert(pieces.classes.end(), part.classes.begin(), part.classes.end());
    pieces.instances.insert(pieces.instances.end(), part.instances.begin(), part.instances.end());
  }
  EXPECT_TRUE(all == pieces);
}

TEST_F(Gl, ATinyCacheGivesTheSamePictures) {
  std::vector<scan::Panorama> panoramas;
  for (std::uint32_t k = 0; k < 9; ++k) panoramas.push_back(noise(24, k));
  const Camera camera{60, 40, degrees(120)};  // most views show four faces or more
  const auto views = random_views(50, panoramas.size(), 2);
  const Pictures roomy = draw(*gl_renderer(cache_of(panoramas)), camera, views);
  const auto tight = gl_renderer(cache_of(panoramas, 1));
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(draw(*tight, camera, views) == roomy) << "time " << k;
}

TEST_F(Gl, MixesPanoramasOfDifferentSizes) {
  const std::vector<scan::Panorama> panoramas{noise(16, 1), noise(40, 2), noise(25, 3)};
  const Camera camera{50, 50, degrees(90)};
  const auto views = random_views(30, panoramas.size(), 4);
  const auto renderer = gl_renderer(cache_of(panoramas));
  const Pictures mixed = draw(*renderer, camera, views);
  for (std::size_t k = 0; k < views.size(); ++k) {
    const Pictures one = draw(*renderer, camera, std::span(views).subspan(k, 1));
    const auto at = static_cast<std::ptrdiff_t>(k) * 50 * 50;
    ASSERT_TRUE(std::equal(one.rgb.begin(), one.rgb.end(), mixed.rgb.begin() + 3 * at)) << k;
    ASSERT_TRUE(
        std::equal(one.instances.begin(), one.instances.end(), mixed.instances.begin() + at))
        << k;
  }
}

TEST_F(Gl, GivesEveryColourFormat) {
  const auto renderer = gl_renderer(cache_of({noise(32, 1)}));
  const Camera camera{37, 23, degrees(70)};  // odd: no row begins at a round address
  const auto views = random_views(5, 1, 9);
  const std::size_t plane = std::size_t{37} * 23, n = views.size() * plane;
  const auto rgb = draw_rgb(*renderer, camera, views);
  const auto as = [&](ColourFormat format, auto value) {
    std::vector<decltype(value)> values(n * pixel_bytes(format) / sizeof(value));
    Outputs outputs;
    outputs.colour = ColourOutput{format, kImageNet, bytes(values)};
    renderer->render(camera, views, outputs);
    return values;
  };
  const auto bgr = as(ColourFormat::kBgr8, std::uint8_t{});
  const auto rgba = as(ColourFormat::kRgba8, std::uint8_t{});
  const auto half = as(ColourFormat::kPlanarFloat16, std::uint16_t{});
  const auto single = as(ColourFormat::kPlanarFloat32, float{});
  for (std::size_t k = 0; k < n; ++k) {
    ASSERT_EQ(rgba[4 * k + 3], 255);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint8_t level = rgb[3 * k + c];
      ASSERT_EQ(bgr[3 * k + 2 - c], level);
      ASSERT_EQ(rgba[4 * k + c], level);
      const double expected = (level / 255.0 - double{kImageNet.mean[c]}) / kImageNet.deviation[c];
      const std::size_t at = (k / plane * 3 + c) * plane + k % plane;
      ASSERT_NEAR(single[at], expected, 1e-6);  // float rounding of numbers up to 2.6
      // A half's value: its 11 bits are worth 2^-10 at numbers from 2 to 4.
      const int exponent = (half[at] >> 10 & 31) - 15;
      const double magnitude = exponent == -15
                                   ? std::ldexp(half[at] & 1023, -24)
                                   : std::ldexp(1024 + (half[at] & 1023), exponent - 10);
      ASSERT_NEAR((half[at] & 0x8000) != 0 ? -magnitude : magnitude, expected, 1.0 / 1024);
    }
  }
}

// A sphere around the eye: 2.5 m away in all directions, class 300, instance 0x12345678.
scan::Panorama sphere() {
  scan::Panorama p = noise(8, 1);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    std::ranges::fill(p.depth[k].pixels, std::uint16_t{10000});
    std::ranges::fill(p.classes[k].pixels, std::uint16_t{300});
    std::ranges::fill(p.instances[k].pixels, 0x12345678U);
  }
  return p;
}

TEST_F(Gl, GivesEveryDepthFormatAndIds) {
  const auto cache = cache_of({sphere()});
  const auto native = gl_renderer(cache), legacy = gl_renderer(cache, {false, true});
  const Camera camera{31, 17, degrees(90)};
  const auto views = random_views(3, 1, 1);
  const std::size_t n = views.size() * 31 * 17;
  std::vector<float> z(n), ray(n);
  std::vector<std::uint16_t> units(n), steps(n);
  std::vector<std::uint8_t> classes(n);
  std::vector<std::uint32_t> instances(n);
  Outputs outputs;
  outputs.classes = ClassOutput{ClassFormat::kUint8, bytes(classes)};
  outputs.instances = InstanceOutput{instances};
  outputs.depth = DepthOutput{DepthFormat::kMetresFloat32, DepthMeasure::kZ, bytes(z)};
  native->render(camera, views, outputs);
  outputs.depth = DepthOutput{DepthFormat::kMetresFloat32, DepthMeasure::kRay, bytes(ray)};
  native->render(camera, views, outputs);
  outputs.depth =
      DepthOutput{DepthFormat::kQuarterMillimetresUint16, DepthMeasure::kZ, bytes(units)};
  native->render(camera, views, outputs);
  outputs.depth->pixels = bytes(steps);
  legacy->render(camera, views, outputs);
  for (std::size_t k = 0; k < n; ++k) {
    const double y = (static_cast<double>(k / 31 % 17) - 8) * 2 / 17;
    const double x = (static_cast<double>(k % 31) - 15) * 2 / 17;
    const double expected = 10000 / std::sqrt(x * x + y * y + 1);
    ASSERT_NEAR(z[k], expected / 4000, 1e-6);  // float rounding of numbers up to 2.5
    ASSERT_FLOAT_EQ(ray[k], 2.5F);
    ASSERT_NEAR(units[k], expected, 0.502);  // to nearest, of a float of 24 bits
    ASSERT_EQ(steps[k], std::lround(expected / 257) * 257);
    ASSERT_EQ(classes[k], 255);
    ASSERT_EQ(instances[k], 0x12345678U);
  }
}

TEST_F(Gl, LegacyEdgesAreNotFilteredAcross) {
  scan::Panorama p;
  p.colour = painted(8, [](CubeFace face, double, double) -> Texels {
    const auto k = static_cast<std::uint8_t>(index(face) * 50);
    return {k, k, k};
  });
  const auto cache = cache_of({p});
  const auto views = random_views(20, 1, 3);
  const Camera camera{64, 64, degrees(100)};
  const auto mixed = [&](Legacy legacy) {
    return std::ranges::count_if(draw_rgb(*gl_renderer(cache, legacy), camera, views),
                                 [](std::uint8_t v) { return v % 50 != 0; });
  };
  EXPECT_EQ(mixed({true, false}), 0);
  EXPECT_GT(mixed({false, false}), 1000);
}

TEST_F(Gl, APixelShowsTheFaceThatItsRayMeets) {
  scan::Panorama p;
  p.colour = painted(2, [](CubeFace face, double, double) -> Texels {
    return {static_cast<std::uint8_t>(index(face)), 0, 0};
  });
  const auto renderer = gl_renderer(cache_of({p}), {true, false});
  const Mat3d panorama_from_world{{1, 0, 0, 0, 0, -1, 0, 1, 0}};
  const Camera camera{320, 240, degrees(80)};
  const auto views = random_views(100, 1, 6);
  const auto rgb = draw_rgb(*renderer, camera, views);
  for (std::size_t k = 0; k < views.size(); ++k) {
    const PixelRays rays = pixel_rays(
        camera, panorama_from_world * world_from_camera(views[k].heading, views[k].elevation));
    for (std::size_t i = 0; i < camera.height; ++i) {
      for (std::size_t j = 0; j < camera.width; ++j) {
        const Vec3d ray = rays.at(static_cast<double>(i), static_cast<double>(j));
        const FacePoint meets = project_to_cube(ray);
        ASSERT_EQ(rgb[((k * camera.height + i) * camera.width + j) * 3], index(meets.face))
            << "view " << k << ", row " << i << ", column " << j;
      }
    }
  }
}

TEST_F(Gl, TwoRenderersInTwoThreadsDoNotDisturbEachOther) {
  const auto cache = cache_of({noise(32, 1), noise(32, 2), noise(32, 3)});
  const Camera camera{80, 60, degrees(80)};
  const auto views = random_views(40, 3, 8);
  const Pictures alone = draw(*gl_renderer(cache), camera, views);
  std::atomic<int> different = 0;
  const auto work = [&] {
    const auto renderer = gl_renderer(cache);
    for (int k = 0; k < 25; ++k) different += draw(*renderer, camera, views) == alone ? 0 : 1;
  };
  std::thread first(work), second(work);
  first.join();
  second.join();
  EXPECT_EQ(different, 0);
}

TEST_F(Gl, OneMayBeDestroyedWhileAnotherDraws) {
  const auto cache = cache_of({noise(32, 1)});
  const Camera camera{80, 60, degrees(80)};
  const auto views = random_views(10, 1, 8);
  const auto lasting = gl_renderer(cache);
  const Pictures before = draw(*lasting, camera, views);
  std::atomic<bool> done = false;
  std::thread others([&] {
    for (int k = 0; k < 10; ++k) draw(*gl_renderer(cache), camera, views);
    done = true;
  });
  bool same = true;
  while (!done) same = draw(*lasting, camera, views) == before && same;
  others.join();
  EXPECT_TRUE(same);
}

TEST_F(Gl, MayMoveToAnotherThreadAndLeavesNothingCurrent) {
  const auto cache = cache_of({noise(16, 1)});
  const auto first = gl_renderer(cache), second = gl_renderer(cache);
  const Camera camera{20, 20, degrees(80)};
  const auto views = random_views(3, 1, 8);
  const Pictures here = draw(*first, camera, views);
  EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
  std::thread([&] { EXPECT_TRUE(draw(*first, camera, views) == here); }).join();
  EXPECT_TRUE(draw(*second, camera, views) == here);
  EXPECT_TRUE(draw(*first, camera, views) == here);
}

TEST_F(Gl, GoesOnAfterAFailure) {
  scan::Panorama no_depth = noise(16, 2);
  no_depth.depth = {};
  const auto cache = cache_of({noise(16, 1), no_depth, noise(16, 3)});
  const auto renderer = gl_renderer(cache);
  const Camera camera{200, 200, degrees(80)};
  const auto good = random_views(60, 1, 8);
  auto bad = good;
  bad.back().viewpoint = ViewpointIndex(1);  // in a later target, while others are on their way
  const Pictures before = draw(*renderer, camera, good);
  for (int k = 0; k < 3; ++k) {
    EXPECT_THROW(draw(*renderer, camera, bad), LookupError);
    EXPECT_EQ(eglGetCurrentContext(), EGL_NO_CONTEXT);
    EXPECT_TRUE(draw(*renderer, camera, good) == before);
  }
  // A panorama that had its place already, but was not brought in, when the next one failed.
  auto fresh = random_views(1, 1, 9);
  fresh[0].viewpoint = ViewpointIndex(2);
  bad = {fresh[0], bad.back()};
  EXPECT_THROW(draw(*renderer, camera, bad), LookupError);
  EXPECT_TRUE(draw(*renderer, camera, fresh) == draw(*gl_renderer(cache), camera, fresh));
}

TEST_F(Gl, ChoosesADeviceByIndexOrUuid) {
  const auto cache = cache_of({noise(16, 1)});
  RendererConfig config;
  config.backend = Backend::kGl;
  for (const GlDevice& device : gl_devices()) {
    config.gl_device = device.name;
    if (!device.works) {
      EXPECT_THAT(tests::refusal<Error>([&] { detail::make_gl_renderer(cache, config); }),
                  HasSubstr(device.error));
      continue;
    }
    EXPECT_THAT(detail::make_gl_renderer(cache, config)->description(), HasSubstr(device.renderer));
    if (device.uuid.empty()) continue;
    config.gl_device = device.uuid;
    EXPECT_THAT(detail::make_gl_renderer(cache, config)->description(), HasSubstr("gl ("));
  }
}

TEST_F(Gl, AnUnknownDeviceIsRefusedWithAListOfThoseThereAre) {
  RendererConfig config;
  for (const std::string name : {"77", "nvidia", "00000000-0000-0000-0000-0000000000ff"}) {
    config.gl_device = name;
    const std::string message = tests::refusal<ArgumentError>(
        [&] { detail::make_gl_renderer(cache_of({noise(16, 1)}), config); });
    EXPECT_THAT(message, HasSubstr(name));
    for (const GlDevice& device : gl_devices()) EXPECT_THAT(message, HasSubstr(device.name));
  }
}

TEST_F(Gl, TooLargePicturesAreRefusedWithTheLimit) {
  const auto renderer = gl_renderer(cache_of({noise(16, 1)}));
  const Camera camera{1U << 20, 1, degrees(60)};
  EXPECT_THAT(tests::refusal<Error>([&] { draw(*renderer, camera, random_views(1, 1, 1)); }),
              HasSubstr("1048576 x 1 pixels: the device draws at most"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::render
