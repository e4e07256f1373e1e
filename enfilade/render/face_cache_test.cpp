#include "enfilade/render/face_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "enfilade/core/errors.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/scan/store.h"
#include "tests/support/colour_texel.h"
#include "tests/support/made_panoramas.h"
#include "tests/support/panoramas.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::render {
namespace EN_UNIT {

using scan::Layer;

FaceKey key(std::size_t viewpoint, Layer layer, std::size_t face) {
  return {ScanIndex(0), ViewpointIndex(viewpoint), layer, cube_face(face)};
}

std::array<std::uint8_t, 3> colour_at(const Face& face, std::ptrdiff_t x, std::size_t y) {
  return image::colour_texel(face.cells, face.size, x, static_cast<std::ptrdiff_t>(y));
}

template <class T>
T value_at(const Face& face, std::size_t x, std::size_t y) {
  T value = 0;
  std::memcpy(&value, face.cells + image::ValueCells<T>::offset(face.size, x, y), sizeof(T));
  return value;
}

TEST(FaceCache, GivesFacesWithTheirBorders) {
  const scan::Panorama made = testing::made_panorama(8);
  const auto cache = testing::cache_of({made});
  const std::array<FaceKey, 3> keys{key(0, Layer::kColour, 2), key(0, Layer::kDepth, 1),
                                    key(0, Layer::kInstance, 5)};
  std::array<Face, 3> faces;
  cache->acquire(keys, faces);
  EXPECT_EQ(faces[0].size, 8U);
  for (std::size_t y = 0; y < 8; ++y) {
    for (std::size_t x = 0; x < 8; ++x) {
      const auto rgb = colour_at(faces[0], static_cast<std::ptrdiff_t>(x), y);
      EXPECT_TRUE(std::ranges::equal(rgb, std::span(made.colour[2].at(x, y), 3)));
      EXPECT_EQ(value_at<std::uint16_t>(faces[1], x, y), *made.depth[1].at(x, y));
      EXPECT_EQ(value_at<std::uint32_t>(faces[2], x, y), *made.instances[5].at(x, y));
    }
  }
  // Left of face 2 is the right column of face 1.
  EXPECT_TRUE(
      std::ranges::equal(colour_at(faces[0], -1, 3), std::span(made.colour[1].at(7, 3), 3)));
  cache->release(keys);
}

TEST(FaceCache, KeepsToItsBytesAndForgetsTheOldestFirst) {
  std::vector<scan::Panorama> panoramas(4, testing::made_panorama(32));
  FaceCacheConfig config;
  config.bytes = 3 * face_bytes(Layer::kColour, 32);
  const auto cache = testing::cache_of(std::move(panoramas), config);
  const auto touch = [&](std::size_t viewpoint) {
    const FaceKey k = key(viewpoint, Layer::kColour, 0);
    Face face;
    const auto before = cache->counters().misses;
    cache->acquire({&k, 1}, {&face, 1});
    cache->release({&k, 1});
    return cache->counters().misses > before;
  };
  EXPECT_TRUE(touch(0));
  EXPECT_TRUE(touch(1));
  EXPECT_TRUE(touch(2));
  EXPECT_FALSE(touch(0));  // now 1 is the oldest
  EXPECT_TRUE(touch(3));
  EXPECT_FALSE(touch(0));
  EXPECT_TRUE(touch(1));
  EXPECT_LE(cache->counters().bytes, config.bytes);
}

TEST(FaceCache, WhatIsHeldStaysEvenBeyondItsBytes) {
  FaceCacheConfig config;
  config.bytes = 1;
  const auto cache = testing::cache_of({testing::made_panorama(16)}, config);
  std::array<FaceKey, 6> keys;
  std::array<Face, 6> faces;
  for (std::size_t k = 0; k < 6; ++k) keys[k] = key(0, Layer::kColour, k);
  cache->acquire(keys, faces);
  EXPECT_GT(cache->counters().bytes, 6U * face_bytes(Layer::kColour, 16) - 1);
  cache->clear();  // forgets only what nobody holds
  EXPECT_GT(cache->counters().bytes, 6U * face_bytes(Layer::kColour, 16) - 1);
  cache->release(keys);
  cache->clear();
  EXPECT_EQ(cache->counters().bytes, 0U);
}

TEST(FaceCache, PrefetchedFacesAreThereWhenAsked) {
  const auto cache = testing::made_cache(16, 2);
  const std::array<FaceKey, 2> keys{key(1, Layer::kColour, 3), key(1, Layer::kDepth, 3)};
  cache->prefetch(keys);
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (cache->counters().prefetched < 2 && std::chrono::steady_clock::now() < limit) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::array<Face, 2> faces;
  cache->acquire(keys, faces);
  cache->release(keys);
  EXPECT_EQ(cache->counters().misses, 0U);
  EXPECT_EQ(cache->counters().hits, 2U);
}

TEST(FaceCache, AFailureLeavesNothingHeldAndCanBeTriedAgain) {
  scan::Panorama half = testing::made_panorama(8);
  half.classes = {};
  const auto cache = testing::cache_of({half});
  const std::array<FaceKey, 2> keys{key(0, Layer::kColour, 0), key(0, Layer::kClass, 0)};
  std::array<Face, 2> faces;
  for (int k = 0; k < 2; ++k) {
    EXPECT_THROW(cache->acquire(keys, faces), LookupError);
    cache->clear();
    EXPECT_EQ(cache->counters().bytes, 0U);
  }
  cache->prefetch(keys);  // not there: passed over
}

TEST(FaceCache, TakesNoMemoryForFacesThatTheirStoreHasInCells) {
  const tests::TemporaryFolder folder("cache_of_cells");
  const auto made = scan::testing::memory_panoramas("house", 2, 24);
  scan::PackOptions options;
  options.decoded = true;
  options.colour = scan::ColourCoding::kRaw;
  const auto store = scan::Store::open(scan::pack(*made, folder.path(), options).file);
  const auto cells = std::make_shared<FaceCache>(scan::PanoramaSet::of({store}));
  const auto decoded = std::make_shared<FaceCache>(scan::PanoramaSet::of({made}));
  const Camera camera{90, 70, degrees(80)};
  Rng rng(31, 0);
  for (int k = 0; k < 10; ++k) {
    const View view = testing::random_view(rng, 2);
    testing::Pictures a(camera, 1), b(camera, 1);
    make_renderer(cells)->render(camera, {&view, 1}, a.outputs());
    make_renderer(decoded)->render(camera, {&view, 1}, b.outputs());
    EXPECT_EQ(a, b) << "view " << k;
  }
  EXPECT_EQ(cells->counters().bytes, 0U);
  EXPECT_GT(decoded->counters().bytes, 0U);
}

// With 1 to 12 faces missing, of 1 to 8 threads: whole faces, and what is left over in parts.
TEST(FaceCache, ThreadsShareAFaceWhoseRowsCanBeReadAlone) {
  constexpr std::uint32_t kSize = 70;
  const tests::TemporaryFolder folder("cache_of_rows");
  const auto made = scan::testing::memory_panoramas("house", 2, kSize);
  scan::PackOptions options;
  options.colour = scan::ColourCoding::kJpeg;
  const auto store = scan::Store::open(scan::pack(*made, folder.path(), options).file);
  std::array<FaceKey, 12> keys;
  for (std::size_t k = 0; k < keys.size(); ++k) keys[k] = key(k / 6, Layer::kColour, k % 6);
  scan::testing::BorderedMap right(kSize);
  for (const int threads : {1, 2, 3, 8}) {
    FaceCacheConfig config;
    config.threads = threads;
    const auto cache = std::make_shared<FaceCache>(scan::PanoramaSet::of({store}), config);
    for (std::size_t count = 1; count <= keys.size(); ++count) {
      cache->clear();
      std::array<Face, 12> faces;
      const auto wanted = std::span(keys).first(count);
      cache->acquire(wanted, std::span(faces).first(count));
      for (std::size_t k = 0; k < count; ++k) {
        if (k % 6 == 0) store->read_colour(ViewpointIndex(k / 6), scan::kAllFaces, right.faces());
        const std::ptrdiff_t end = kSize;
        for (std::ptrdiff_t y = -1; y <= end; ++y) {
          for (std::ptrdiff_t x = -1; x <= end; ++x) {
            ASSERT_EQ(image::colour_texel(faces[k].cells, kSize, x, y),
                      image::colour_texel(right.faces()[k % 6].cells, kSize, x, y))
                << threads << " threads, face " << k << " of " << count;
          }
        }
      }
      cache->release(wanted);
      EXPECT_EQ(cache->counters().misses, count * (count + 1) / 2);
    }
  }
}

TEST(FaceCache, KeepsAShareOfTheMachinesMemoryIfNotTold) {
  EXPECT_GE(default_cache_bytes(), std::size_t{64} << 20);
  EXPECT_LE(default_cache_bytes(), std::size_t{1} << 30);
}

TEST(FaceCache, NeedsPanoramas) { EXPECT_THROW(FaceCache(nullptr), ArgumentError); }

}  // namespace EN_UNIT
}  // namespace enfilade::render
