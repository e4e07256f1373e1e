// The vector kernels against their plain twin; threads; allocations.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <thread>

#include "enfilade/core/errors.h"
#include "enfilade/render/cpu/kernels.h"
#include "enfilade/render/devices.h"
#include "tests/support/made_panoramas.h"

namespace enfilade::render {
namespace EN_UNIT {

using testing::cache_of;
using testing::Pictures;
using testing::random_view;

// A panorama in which no texel is like its neighbours.
scan::Panorama noise(std::uint32_t size, std::uint64_t seed) {
  scan::Panorama p = testing::made_panorama(size);
  Rng rng(seed, 0);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    for (auto& v : p.colour[k].pixels) v = static_cast<std::uint8_t>(rng.below(256));
    for (auto& v : p.depth[k].pixels) v = static_cast<std::uint16_t>(rng.below(65536));
    for (auto& v : p.instances[k].pixels) v = static_cast<std::uint32_t>(rng.below(1ULL << 32));
  }
  return p;
}

// All instruction sets that this machine has, with gathers and without.
class EachTarget : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(CpuRenderer, EachTarget, ::testing::ValuesIn(cpu_targets()),
                         [](const auto& each) {
                           std::string name = each.param;
                           std::ranges::replace(name, ' ', '_');
                           return name;
                         });

TEST_P(EachTarget, GivesTheBytesOfItsPlainTwin) {
  // 512: has_near_strips(), and so another way to the offsets; 256: not.
  for (const std::uint32_t size : {1U, 2U, 17U, 31U, 256U, 512U}) {
    const auto cache = cache_of({noise(size, 1), noise(size, 2)});
    for (const Legacy legacy : {Legacy{}, Legacy{true, true}}) {
      const auto simd = make_renderer(cache, {Backend::kCpu, 1, legacy, {}, GetParam()});
      const auto twin = make_renderer(cache, {Backend::kCpuScalar, 1, legacy, {}});
      Rng rng(21, size);
      for (int k = 0; k < 30; ++k) {
        const Camera camera{1 + static_cast<std::uint32_t>(rng.below(700)),
                            1 + static_cast<std::uint32_t>(rng.below(30)),
                            degrees(1 + 170 * rng.uniform())};
        const std::vector<View> views{random_view(rng, 2), random_view(rng, 2)};
        Pictures a(camera, 2), b(camera, 2);
        simd->render(camera, views, a.outputs());
        twin->render(camera, views, b.outputs());
        ASSERT_EQ(a, b) << "faces of " << size << ", view " << k;
        // Colour and depth alone are placed in one pass.
        Pictures two(camera, 2);
        Outputs outputs = two.outputs();
        outputs.classes.reset();
        outputs.instances.reset();
        simd->render(camera, views, outputs);
        ASSERT_EQ(two.colour, b.colour) << "faces of " << size << ", view " << k;
        ASSERT_EQ(two.depth, b.depth) << "faces of " << size << ", view " << k;
      }
    }
  }
}

TEST_P(EachTarget, DrawsEachFormatAsItsPlainTwin) {
  const auto cache = cache_of({noise(64, 1)});
  const auto simd = make_renderer(cache, {Backend::kCpu, 1, {}, {}, GetParam()});
  const auto twin = make_renderer(cache, {Backend::kCpuScalar, 1, {}, {}});
  Rng rng(26, 0);
  for (const ColourFormat format : {ColourFormat::kRgb8, ColourFormat::kBgr8, ColourFormat::kRgba8,
                                    ColourFormat::kPlanarFloat16, ColourFormat::kPlanarFloat32}) {
    for (std::uint32_t width = 1; width < 40; ++width) {
      const Camera camera{width, 5, degrees(100)};
      const View view = random_view(rng);
      const auto drawn = [&](Renderer& renderer) {
        std::vector<std::byte> pixels(std::size_t{5} * width * pixel_bytes(format));
        Outputs outputs;
        outputs.colour = ColourOutput{format, kImageNet, pixels};
        renderer.render(camera, {&view, 1}, outputs);
        return pixels;
      };
      ASSERT_EQ(drawn(*simd), drawn(*twin)) << "width " << width;
    }
  }
}

// A view's faces may be farther apart in memory than offsets of 31 bits reach.
TEST(CpuRenderer, FacesThatAreFarApartMakeTheSamePictures) {
  // A block of the cache's memory has 17 faces of colour, or 19 of 16 bits: depth and classes.
  constexpr std::uint32_t kSize = 512;
  const auto make = [] { return cache_of({noise(kSize, 1), noise(kSize, 2), noise(kSize, 3)}); };
  const auto near = make(), far = make();
  std::vector<FaceKey> keys;
  for (const scan::Layer layer : {scan::Layer::kColour, scan::Layer::kDepth}) {
    for (std::size_t k = 0; k < 18; ++k) {
      keys.push_back({ScanIndex(0), ViewpointIndex(k / 6), layer, cube_face(k % 6)});
    }
  }
  for (std::size_t k = 0; k < 4; ++k) {
    keys.push_back({ScanIndex(0), ViewpointIndex(0), scan::Layer::kClass, cube_face(k)});
  }
  std::vector<Face> faces(keys.size());
  const auto load = [&](std::size_t begin, std::size_t end) {
    const std::span some = std::span(keys).subspan(begin, end - begin);
    far->acquire(some, std::span(faces).subspan(begin, end - begin));
    far->release(some);
  };
  load(0, 15);
  load(36, 40);
  load(18, 33);
  // Address space without memory: a large hole, and whatever gaps are left above it.
  std::vector<std::pair<void*, std::size_t>> taken;
  const auto take = [&](std::size_t bytes) {
    void* at = mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    taken.emplace_back(at, bytes);
    return at;
  };
  const void* hole = take(std::size_t{3} << 30);
  while (taken.size() < 2000 && take(std::size_t{8} << 20) > hole) {
  }
  load(15, 18);
  load(33, 36);
  for (const auto& [at, bytes] : taken) munmap(at, bytes);
  const auto apart = [&](std::size_t a, std::size_t b) {
    return std::abs(faces[a].cells - faces[b].cells) >= std::ptrdiff_t{1} << 31;
  };
  if (!apart(12, 17) || !apart(30, 35)) {
    GTEST_SKIP() << "this system maps memory in another order";
  }
  const Camera camera{200, 200, degrees(100)};
  Rng rng(27, 0);
  for (int k = 0; k < 20; ++k) {
    View view = random_view(rng);
    view.viewpoint = ViewpointIndex(2);
    Pictures a(camera, 1), b(camera, 1);
    make_renderer(far, {Backend::kCpu, 1, {}, {}})->render(camera, {&view, 1}, a.outputs());
    make_renderer(near, {Backend::kCpu, 1, {}, {}})->render(camera, {&view, 1}, b.outputs());
    EXPECT_EQ(a, b) << "view " << k;
  }
}

TEST(CpuRenderer, RefusesAnInstructionSetThatIsNotThere) {
  EXPECT_THAT(
      [] {
        make_renderer(cache_of({noise(2, 1)}), {Backend::kCpu, 1, {}, {}, "MMX"});
      },
      ::testing::ThrowsMessage<ArgumentError>(::testing::AllOf(
          ::testing::HasSubstr("\"MMX\""), ::testing::HasSubstr(cpu_targets().back()))));
}

TEST_P(EachTarget, PacksAsItsPlainTwinAtEveryLengthAndAlignment) {
  const cpu::PixelKernels& simd = cpu::simd_kernels(GetParam());
  const cpu::PixelKernels& twin = cpu::scalar_kernels();
  Rng rng(22, 0);
  cpu::Block32 block;
  cpu::Block16 depth;
  std::array<float, cpu::kBlock> factor;
  for (auto& v : block.values) v = static_cast<std::uint32_t>(rng.below(1ULL << 32));
  for (auto& v : depth.values) v = static_cast<std::uint16_t>(rng.below(65536));
  for (auto& v : factor) v = static_cast<float>(rng.uniform());
  const cpu::PlanarScale scale{{0.017F, 0.0175F, 0.0174F}, {-2.1F, -2.03F, -1.8F}};
  constexpr std::uint8_t kUntouched = 0xA5;
  for (std::size_t count = 0; count < 80; ++count) {
    std::vector<std::uint8_t> a(4096, kUntouched), b(4096, kUntouched);
    const auto both = [&](auto call) {
      call(simd, a.data() + 64);
      call(twin, b.data() + 64);
      ASSERT_EQ(a, b) << "count " << count;
    };
    both([&](const cpu::PixelKernels& k, std::uint8_t* out) {
      k.pack_rgb(block.values.data(), count, out + 1);
      k.pack_bgr(block.values.data(), count, out + 301);
    });
    both([&](const cpu::PixelKernels& k, std::uint8_t* out) {
      k.pack_planar16(block.values.data(), count, scale, 100,
                      reinterpret_cast<std::uint16_t*>(out + 2));
      k.pack_planar32(block.values.data(), count, scale, 100, reinterpret_cast<float*>(out + 1024));
    });
    both([&](const cpu::PixelKernels& k, std::uint8_t* out) {
      k.pack_metres(depth.values.data(), factor.data(), count, reinterpret_cast<float*>(out + 4));
      k.pack_units(depth.values.data(), factor.data(), count,
                   reinterpret_cast<std::uint16_t*>(out + 1026));
      k.pack_legacy_units(depth.values.data(), factor.data(), count,
                          reinterpret_cast<std::uint16_t*>(out + 2050));
    });
    both([&](const cpu::PixelKernels& k, std::uint8_t* out) {
      k.stream(reinterpret_cast<std::byte*>(out + count % 7),
               reinterpret_cast<const std::byte*>(&block), 4 * count);
      k.stream_end();
    });
  }
}

TEST(CpuRenderer, ThreadsDoNotChangeABit) {
  const auto cache = cache_of({noise(64, 1), noise(64, 2), noise(64, 3)});
  const Camera camera{320, 240, degrees(60)};
  Rng rng(23, 0);
  std::vector<View> views;
  for (int k = 0; k < 7; ++k) views.push_back(random_view(rng, 3));
  Pictures first(camera, views.size());
  make_renderer(cache, {Backend::kCpu, 1, {}, {}})->render(camera, views, first.outputs());
  for (const int threads : {2, 0}) {
    Pictures other(camera, views.size());
    make_renderer(cache, {Backend::kCpu, threads, {}, {}})->render(camera, views, other.outputs());
    EXPECT_EQ(first, other) << threads << " threads";
  }
}

TEST(CpuRenderer, TwoInTwoThreadsShareASmallCacheInPeace) {
  FaceCacheConfig config;
  config.bytes = 150'000;  // each pushes out what the other has just used
  std::vector<scan::Panorama> panoramas;
  for (std::uint64_t k = 0; k < 5; ++k) panoramas.push_back(noise(32, k));
  const auto cache = cache_of(std::move(panoramas), config);
  const Camera camera{60, 40, degrees(60)};
  const auto draw = [&](std::uint64_t seed) {
    const auto renderer = make_renderer(cache, {Backend::kCpu, 1, {}, {}});
    Rng rng(24, seed);
    std::vector<Pictures> all;
    for (int k = 0; k < 40; ++k) {
      const std::vector<View> views{random_view(rng, 5), random_view(rng, 5)};
      all.emplace_back(camera, 2);
      renderer->render(camera, views, all.back().outputs());
    }
    return all;
  };
  const auto alone_a = draw(1), alone_b = draw(2);
  std::vector<Pictures> a, b;
  {
    const std::jthread one([&] { a = draw(1); });
    const std::jthread two([&] { b = draw(2); });
  }
  EXPECT_EQ(a, alone_a);
  EXPECT_EQ(b, alone_b);
}

TEST(CpuRenderer, LargeBatchesAreStreamedToTheSameBytes) {
  const auto cache = cache_of({noise(32, 1)});
  const auto renderer = make_renderer(cache, {Backend::kCpu, 1, {}, {}});
  const Camera camera{512, 512, degrees(60)};  // above 64 MiB at 60 views; rows of whole lines
  Rng rng(25, 0);
  std::vector<View> views;
  for (int k = 0; k < 60; ++k) views.push_back(random_view(rng));
  Pictures all(camera, views.size()), one(camera, 1);
  renderer->render(camera, views, all.outputs());
  for (std::size_t k = 0; k < views.size(); ++k) {
    renderer->render(camera, {&views[k], 1}, one.outputs());
    for (std::size_t p = 0; p < one.pixels; p += 5) {  // each place of a line in its turn
      ASSERT_EQ(all.channel(k * one.pixels + p, 1), one.channel(p, 1));
      ASSERT_EQ(all.depth[k * one.pixels + p], one.depth[p]);
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::render
