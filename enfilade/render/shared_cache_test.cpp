// FaceCaches that share a file.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <thread>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/render/face_cache.h"
#include "tests/support/made_panoramas.h"
#include "tests/support/panoramas.h"
#include "tests/support/shared_memory.h"

namespace enfilade::render {
namespace EN_UNIT {

using scan::Layer;
using tests::in_child;
using tests::wait_for;

constexpr std::uint32_t kSize = 64;
constexpr std::size_t kViewpoints = 3;

std::vector<FaceKey> all_keys() {
  std::vector<FaceKey> keys;
  for (std::size_t v = 0; v < kViewpoints; ++v) {
    for (const Layer layer : {Layer::kColour, Layer::kDepth, Layer::kClass, Layer::kInstance}) {
      for (std::size_t k = 0; k < kCubeFaces; ++k) {
        keys.push_back({ScanIndex(0), ViewpointIndex(v), layer, cube_face(k)});
      }
    }
  }
  return keys;
}

// Without what lies between texels, which is unspecified; values of 64 texels leave no gaps.
std::vector<std::uint8_t> texels(Layer layer, const Face& face) {
  const std::size_t bytes = scan::cells_bytes(layer, face.size);
  if (layer != Layer::kColour) return {face.cells, face.cells + bytes};
  std::vector<std::uint8_t> rgba(std::size_t{4} * (face.size + 2) * (face.size + 2));
  image::bordered_rgba(face.cells, face.size, rgba);
  return rgba;
}

class SharedCache : public ::testing::Test {
 protected:
  std::shared_ptr<FaceCache> cache(std::size_t mebibytes = 16) const {
    FaceCacheConfig config;
    config.shared = {name_.path(), mebibytes << 20U};
    config.threads = 2;
    return std::make_shared<FaceCache>(set_, config);
  }
  // How many of the faces differ from what a cache of its own has.
  std::size_t wrong(FaceCache& cache, std::span<const FaceKey> keys) const {
    FaceCache own(set_);
    std::vector<Face> here(keys.size()), there(keys.size());
    own.acquire(keys, here);
    cache.acquire(keys, there);
    std::size_t count = 0;
    for (std::size_t k = 0; k < keys.size(); ++k) {
      count += texels(keys[k].layer, here[k]) == texels(keys[k].layer, there[k]) ? 0 : 1;
    }
    cache.release(keys);
    own.release(keys);
    return count;
  }

  tests::SharedName name_{"cache"};
  std::shared_ptr<const scan::PanoramaSource> source_ =
      scan::testing::memory_panoramas("house", kViewpoints, kSize);
  std::shared_ptr<const scan::PanoramaSet> set_ = scan::PanoramaSet::of({source_});
  std::vector<FaceKey> keys_ = all_keys();
};

TEST_F(SharedCache, EachFaceIsDecodedOnceForTwoCaches) {
  const auto one = cache(), other = cache();
  EXPECT_EQ(wrong(*one, keys_), 0U);
  EXPECT_EQ(wrong(*other, keys_), 0U);
  EXPECT_EQ(one->counters().decoded, keys_.size());
  EXPECT_EQ(one->counters().shared_hits, 0U);
  EXPECT_EQ(other->counters().decoded, 0U);
  EXPECT_EQ(other->counters().shared_hits, keys_.size());
  EXPECT_EQ(other->counters().bytes, 0U);
  EXPECT_GT(other->counters().shared_bytes, 0U);
  EXPECT_EQ(wrong(*other, keys_), 0U);
  EXPECT_EQ(other->counters().hits, keys_.size());
  other->clear();
  EXPECT_EQ(other->counters().shared_bytes, 0U);
}

TEST_F(SharedCache, ThreadsAndPrefetchShareToo) {
  const auto one = cache(), other = cache();
  one->prefetch(keys_);
  std::vector<std::size_t> found(4, 1);
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < found.size(); ++k) {
    threads.emplace_back([&, k] { found[k] = wrong(k % 2 == 0 ? *one : *other, keys_); });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(std::accumulate(found.begin(), found.end(), std::size_t{0}), 0U);
  EXPECT_EQ(one->counters().decoded + other->counters().decoded, keys_.size());
}

// Children that inherit the cache, and one of which is killed while it holds and decodes.
TEST_F(SharedCache, EachFaceIsDecodedOnceForManyProcesses) {
  std::array<int, 2> pipe_ends{};
  ASSERT_EQ(pipe(pipe_ends.data()), 0);
  const auto mine = cache();
  EXPECT_EQ(wrong(*mine, std::span(keys_).first(10)), 0U);
  const std::uint64_t decoded_before = mine->counters().decoded;
  std::vector<pid_t> children;
  for (int k = 0; k < 4; ++k) {
    children.push_back(in_child([&] {
      const auto fresh = k < 2 ? mine : cache();
      const std::uint64_t before = fresh->counters().decoded;
      const std::size_t faults = wrong(*fresh, keys_);
      const std::uint64_t decoded = fresh->counters().decoded - before;
      const bool said = write(pipe_ends[1], &decoded, sizeof(decoded)) == sizeof(decoded);
      return said && faults == 0 ? 0 : 1;
    }));
  }
  std::uint64_t decoded = decoded_before;
  for (const pid_t child : children) {
    EXPECT_EQ(wait_for(child), 0);
    std::uint64_t one = 0;
    ASSERT_EQ(read(pipe_ends[0], &one, sizeof(one)), static_cast<ssize_t>(sizeof(one)));
    decoded += one;
  }
  EXPECT_EQ(decoded, keys_.size());
  close(pipe_ends[0]);
  close(pipe_ends[1]);
}

TEST_F(SharedCache, AChildSeesRightFacesWhenItsParentHasReplacedThem) {
  const auto mine = cache(1);  // has room for a part only
  const auto first = std::span(keys_).first(6), rest = std::span(keys_).subspan(6);
  EXPECT_EQ(wrong(*mine, first), 0U);
  std::array<int, 2> go{};
  ASSERT_EQ(pipe(go.data()), 0);
  const pid_t child = in_child([&] {
    char c = 0;
    if (read(go[0], &c, 1) != 1) return 2;
    return wrong(*mine, first) == 0 && wrong(*mine, keys_) == 0 ? 0 : 1;
  });
  for (std::size_t k = 0; k < rest.size(); ++k) EXPECT_EQ(wrong(*mine, rest.subspan(k, 1)), 0U);
  ASSERT_EQ(write(go[1], "x", 1), 1);
  EXPECT_EQ(wait_for(child), 0);
  close(go[0]);
  close(go[1]);
}

TEST_F(SharedCache, WhatDoesNotFitIsInMemoryOfItsOwn) {
  const auto one = cache(1), other = cache(1);
  std::vector<Face> faces(keys_.size()), again(keys_.size());
  one->acquire(keys_, faces);
  EXPECT_GT(one->counters().bytes, 0U);  // the file is full of faces that are held
  EXPECT_GT(one->counters().shared_bytes, 0U);
  EXPECT_EQ(one->counters().decoded, keys_.size());
  EXPECT_EQ(wrong(*other, keys_), 0U);
  EXPECT_EQ(wrong(*one, keys_), 0U);
  one->release(keys_);
  // Now it keeps no more than its share: others find room.
  one->clear();
  EXPECT_EQ(wrong(*other, keys_), 0U);
}

TEST_F(SharedCache, AKilledProcessLeavesAllToTheOthers) {
  const auto mine = cache(1);
  const pid_t child = in_child([&] {
    std::vector<Face> faces(keys_.size());
    cache(1)->acquire(keys_, faces);
    raise(SIGKILL);
    return 0;
  });
  EXPECT_EQ(wait_for(child), 128 + SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(150));  // who runs is asked each 100 ms
  const auto first = std::span(keys_).last(1);
  EXPECT_EQ(wrong(*mine, first), 0U);
  EXPECT_EQ(mine->counters().bytes, 0U);
}

TEST_F(SharedCache, AFailureIsNotShared) {
  scan::Panorama half = testing::made_panorama(8);
  half.classes = {};
  FaceCacheConfig config;
  config.shared = {name_.path(), std::size_t{1} << 20U};
  const auto broken = testing::cache_of({half}, config);
  const std::array<FaceKey, 2> keys{FaceKey{ScanIndex(0), ViewpointIndex(0), Layer::kColour},
                                    FaceKey{ScanIndex(0), ViewpointIndex(0), Layer::kClass}};
  std::array<Face, 2> faces;
  for (int k = 0; k < 2; ++k) EXPECT_THROW(broken->acquire(keys, faces), LookupError);
  EXPECT_EQ(broken->counters().shared_bytes, 0U);
  broken->acquire(std::span(keys).first(1), std::span(faces).first(1));
  broken->release(std::span(keys).first(1));
  EXPECT_GT(broken->counters().shared_bytes, 0U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::render
