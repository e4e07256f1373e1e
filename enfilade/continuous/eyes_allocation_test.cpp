// Drawing and stepping do not touch the heap, once the camera, the batch and the panoramas are
// known.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdlib>
#include <new>
#include <span>
#include <vector>

#include "enfilade/continuous/eyes.h"
#include "enfilade/continuous/habitat/habitat_floor.h"
#include "enfilade/continuous/habitat/sensors.h"
#include "enfilade/continuous/simulator.h"
#include "enfilade/core/enum_names.h"
#include "tests/support/flat_floor.h"
#include "tests/support/lit_rooms.h"
#include "tests/support/made_meshes.h"

// GCC defines __SANITIZE_*__, clang tells through __has_feature.
#if defined(__has_feature)
#define EN_HAS_FEATURE(feature) __has_feature(feature)
#else
#define EN_HAS_FEATURE(feature) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || \
    EN_HAS_FEATURE(address_sanitizer) || EN_HAS_FEATURE(thread_sanitizer)
#define EN_TEST_SANITIZED 1
#else
#define EN_TEST_SANITIZED 0
#endif

#if !EN_TEST_SANITIZED  // sanitizers bring their own
namespace {
thread_local std::size_t allocations = 0;

void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  const std::size_t whole = (size + alignment) / alignment * alignment;
  if (void* memory = std::aligned_alloc(alignment, whole)) return memory;
  throw std::bad_alloc();
}
}  // namespace

// Not inlined: gcc would see memory freed by one half of a pair and warn of a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
  return counted(size, alignof(std::max_align_t));
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
#endif

namespace enfilade::continuous {
namespace EN_UNIT {

using namespace tests;

TEST(Eyes, DrawingAllocatesNothing) {
#if EN_TEST_SANITIZED
  GTEST_SKIP() << "the sanitizer's own allocator is not counted";
#else
  const auto scene = Scene::photographed(tracer_of(cluttered_room(2000, 4)));
  constexpr Camera kColour{112, 112, degrees(90)}, kDepth{128, 128, degrees(90)};
  Rng rng(12);
  std::vector<MeshView> views;
  for (int k = 0; k < 6; ++k) {
    views.push_back({0, place_in_room(rng), Radians(within(rng, 0, 6)), Radians(0)});
  }
  std::vector<std::byte> rgb(3 * views.size() * kColour.width * kColour.height);
  std::vector<float> metres(views.size() * kDepth.width * kDepth.height);
  render::Outputs of_colour, of_depth;
  of_colour.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, rgb};
  of_depth.depth =
      render::DepthOutput{render::DepthFormat::kMetresFloat32, render::DepthMeasure::kZ,
                          std::as_writable_bytes(std::span(metres))};
  for (const Method method : {Method::kRaster, Method::kRays}) {
    Eyes eyes({scene}, {method, 1, {}});
    const auto draw = [&] {
      eyes.render(kColour, views, of_colour);
      eyes.render(kDepth, views, of_depth);
    };
    draw();
    const std::size_t before = allocations;
    for (int k = 0; k < 3; ++k) draw();
    EXPECT_EQ(allocations, before) << enum_name(method);
  }
  const std::size_t before = allocations;
  const std::vector<int> one(1);
  EXPECT_EQ(allocations, before + one.size()) << "the count itself works";
#endif
}

TEST(Sensors, DrawingAllocatesNothing) {
#if EN_TEST_SANITIZED
  GTEST_SKIP() << "the sanitizer's own allocator is not counted";
#else
  using habitat::Lens;
  habitat::Sensors sensors(Scene::photographed(tracer_of(cluttered_room(2000, 4))), 1);
  for (const Lens lens : {Lens::kPinhole, Lens::kEquirectangular, Lens::kFisheye}) {
    const habitat::Sensor sensor{.lens = lens, .double_sphere = {40, 40, 64, 64}};
    std::vector<std::uint8_t> colour(4 * sensor.width * sensor.height);
    std::vector<float> depth(sensor.width * sensor.height);
    const auto draw = [&](float x) {
      sensors.render(sensor, {{x, 1, 0}, {}}, {colour, depth, {}});
    };
    draw(0);
    const std::size_t before = allocations;
    for (const float x : {0.1F, 0.2F, 0.3F}) draw(x);
    EXPECT_EQ(allocations, before) << enum_name(lens);
  }
#endif
}

TEST(ContinuousSimulator, StepsAllocateNothing) {
#if EN_TEST_SANITIZED
  GTEST_SKIP() << "the sanitizer's own allocator is not counted";
#else
  const mesh::RayTracer room(
      std::make_shared<const mesh::Mesh>(mesh::testing::Maker().room(0, 0, 5, 4).mesh));
  const auto ours = std::make_shared<const NavigationMesh>(make_floor_polygons(room));
  const auto habitats = std::make_shared<const habitat::HabitatFloor>(
      habitat::make_nav_mesh(habitat::testing::flat_triangles({{0, -4, 5, 0}})));
  for (const Building& building : {Building("room", ours), Building("room", habitats)}) {
    SimulatorConfig config;
    config.batch_size = 2;
    Simulator simulator(std::make_shared<const Buildings>(std::vector{building}), config);
    const EpisodeStart start{.building = 0, .pose = {{2, 2, 0}, {}, {}}};
    simulator.new_episodes(std::vector(2, start));
    const std::vector<Action> walk{Action::kForward, Action::kForward};
    const std::vector<Action> turn{Action::kLeft, Action::kRight};
    simulator.step(walk);
    const std::size_t before = allocations;
    for (int k = 0; k < 30; ++k) simulator.step(k % 10 == 0 ? turn : walk);
    EXPECT_EQ(allocations, before) << name_of(building.floor->kind());
  }
#endif
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous
