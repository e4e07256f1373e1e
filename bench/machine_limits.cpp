#include "bench/machine_limits.h"

#include <sys/mman.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "bench/cpu_time.h"
#include "enfilade/geometry/cube_map.h"

namespace enfilade::bench {
namespace {

// Sixteen bytes: what every processor of these kinds moves at once.
using Word = std::uint64_t __attribute__((vector_size(16)));

constexpr std::size_t kMiB = std::size_t{1} << 20;

// The compiler must take `value` for changed: it can neither drop nor shorten what leads to it.
template <class T>
void keep(T& value) {
  asm volatile("" : "+r"(value));
}

// Seconds of CPU time of the quickest of `rounds` calls.
template <class F>
double quickest(int rounds, const F& work) {
  double best = 1e9;
  for (int i = 0; i < rounds; ++i) {
    const double start = thread_cpu_seconds();
    work();
    best = std::min(best, thread_cpu_seconds() - start);
  }
  return std::max(best, 1e-9);
}

// An addition of two registers takes one cycle on every processor of the last twenty years, and
// none skips it, as some do with moves and with small constants.
double measure_clock() {
  constexpr std::size_t kUnrolled = 64, kTurns = 1U << 16U;
  std::uint64_t x = 1, y = 3;
  keep(y);
  const auto chain = [&]<std::size_t... I>(std::index_sequence<I...>) {
    for (std::size_t turn = 0; turn < kTurns; ++turn) {
      ((x += y, static_cast<void>(I), keep(x)), ...);
    }
  };
  const double seconds = quickest(10, [&] { chain(std::make_index_sequence<kUnrolled>()); });
  return static_cast<double>(kUnrolled * kTurns) / seconds;
}

// Stores past the caches where there is such an instruction.
void store_past_caches(Word* to, Word value) {
#if defined(__x86_64__)
  asm volatile("movntdq %1, %0" : "=m"(*to) : "x"(value));
#else
  *to = value;
#endif
}

// On large pages where the system has them.
class Buffer {
 public:
  explicit Buffer(std::size_t bytes) : size_(bytes / sizeof(Word)) {
    constexpr std::size_t kLargePage = 2 * kMiB;
    words_.reset(static_cast<Word*>(std::aligned_alloc(kLargePage, bytes)));
    if (!words_) throw std::bad_alloc();
    (void)madvise(words_.get(), bytes, MADV_HUGEPAGE);
    write(1);
  }
  std::size_t bytes() const { return size_ * sizeof(Word); }

  void write(std::uint64_t value) {
    const Word word{value, value};
    for (std::size_t i = 0; i < size_; i += kLine) {
      for (std::size_t k = 0; k < kLine; ++k) words_.get()[i + k] = word;
      asm volatile("" ::: "memory");  // else the compiler calls memset, which may pass the caches
    }
  }
  void write_past_caches(std::uint64_t value) {
    const Word word{value, value};
    for (std::size_t i = 0; i < size_; ++i) store_past_caches(words_.get() + i, word);
  }
  std::uint64_t read(std::size_t first, std::size_t count) const {
    const Word* words = words_.get() + first;
    std::array<Word, kLine> sums{};
    for (std::size_t i = 0; i < count; i += kLine) {
      for (std::size_t k = 0; k < kLine; ++k) sums[k] += words[i + k];
    }
    const Word sum = sums[0] + sums[1] + sums[2] + sums[3];
    return sum[0] + sum[1];
  }
  std::uint64_t read() const { return read(0, size_); }
  // So many bytes from all over it, pieces drawn with replacement.
  std::uint64_t read_pieces(std::size_t bytes) const {
    constexpr std::size_t kPiece = 1024 / sizeof(Word);
    std::uint64_t sum = 0, random = 88172645463325252U;
    const std::size_t pieces = size_ / kPiece;
    for (std::size_t i = 0; i < bytes / 1024; ++i) {
      random ^= random << 13U;  // Marsaglia's xorshift64
      random ^= random >> 7U;
      random ^= random << 17U;
      sum += read(random % pieces * kPiece, kPiece);
    }
    return sum;
  }

 private:
  static constexpr std::size_t kLine = 64 / sizeof(Word);
  struct Free {
    void operator()(Word* words) const { std::free(words); }
  };
  std::unique_ptr<Word, Free> words_;
  std::size_t size_;
};

MemoryRates measure_memory(std::size_t bytes, int rounds) {
  Buffer buffer(bytes);
  const auto rate = [&](const auto& work, std::size_t part = 1) {
    return static_cast<double>(buffer.bytes() / part) / quickest(rounds, work);
  };
  MemoryRates rates{.bytes = buffer.bytes()};
  rates.write = rate([&] { buffer.write(2); });
  rates.read = rate([&] {
    std::uint64_t sum = buffer.read();
    keep(sum);
  });
  constexpr std::size_t kPart = 4;  // the slowest of all: a sample will do
  rates.read_pieces = rate(
      [&] {
        std::uint64_t sum = buffer.read_pieces(buffer.bytes() / kPart);
        keep(sum);
      },
      kPart);
  rates.write_past_caches = rate([&] { buffer.write_past_caches(3); });
  return rates;
}

std::size_t last_level_size() {
  long bytes = -1;
#ifdef _SC_LEVEL3_CACHE_SIZE  // glibc's; 0 on many ARM machines
  bytes = sysconf(_SC_LEVEL3_CACHE_SIZE);
#endif
  return bytes > 0 ? static_cast<std::size_t>(bytes) : 32 * kMiB;
}

std::size_t large_buffer(std::size_t cache) {
  const auto pages = static_cast<std::size_t>(std::max(sysconf(_SC_PHYS_PAGES), 1L));
  const auto page = static_cast<std::size_t>(std::max(sysconf(_SC_PAGESIZE), 1L));
  const std::size_t wanted = std::clamp(2 * cache, 256 * kMiB, 512 * kMiB);
  const std::size_t most = std::max(pages * page / 8, 4 * kMiB);
  return std::min(wanted, most) / (2 * kMiB) * (2 * kMiB);
}

// Marks what one view reads, and counts it.
class Marks {
 public:
  explicit Marks(std::uint32_t face_size)
      : n_(face_size), seen_(kCubeFaces * n_ * n_), size_(static_cast<double>(face_size)) {}

  void mark_linear(const FacePoint& p) {
    const std::array<std::size_t, 2> xs{clamped(p.s * size_ - 0.5), clamped(p.s * size_ + 0.5)};
    const std::array<std::size_t, 2> ys{clamped(p.t * size_ - 0.5), clamped(p.t * size_ + 0.5)};
    for (const std::size_t y : ys) {
      for (const std::size_t x : xs) mark(p.face, x, y);
    }
  }
  void mark_nearest(const FacePoint& p) {
    mark(p.face, clamped(p.s * size_), clamped(p.t * size_));
  }
  std::size_t count() const { return static_cast<std::size_t>(std::ranges::count(seen_, 1)); }

 private:
  std::size_t clamped(double at) const {
    return static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, size_ - 1));
  }
  void mark(CubeFace face, std::size_t x, std::size_t y) {
    seen_[(index(face) * n_ + y) * n_ + x] = 1;
  }
  std::size_t n_;
  std::vector<std::uint8_t> seen_;
  double size_;
};

// The panorama's z is the world's y, its y the world's -z.
constexpr Mat3d kPanoramaFromWorld{{1, 0, 0, 0, 0, -1, 0, 1, 0}};

}  // namespace

MachineLimits measure_machine_limits() {
  MachineLimits limits{.cache_size = last_level_size(), .cache = {}, .memory = {}};
  limits.clock_hz = measure_clock();
  // Large enough not to fit into a second level, small enough to be left alone by its neighbours.
  const std::size_t within = std::clamp(limits.cache_size / 2, 4 * kMiB, 16 * kMiB);
  limits.cache = measure_memory(within / (2 * kMiB) * (2 * kMiB), 6);
  limits.memory = measure_memory(large_buffer(limits.cache_size), 2);
  return limits;
}

TexelsSeen texels_seen(const Camera& camera, std::uint32_t face_size) {
  TexelsSeen mean;
  // A quarter turn maps an upright cube onto itself: a quarter of the views tells all.
  constexpr std::array kHeadings{0.0, 30.0, 60.0}, kElevations{-30.0, 0.0, 30.0};
  for (const double heading : kHeadings) {
    for (const double elevation : kElevations) {
      const PixelRays rays = pixel_rays(
          camera, kPanoramaFromWorld * world_from_camera(degrees(heading), degrees(elevation)));
      Marks linear(face_size), nearest(face_size);
      for (std::uint32_t i = 0; i < camera.height; ++i) {
        for (std::uint32_t j = 0; j < camera.width; ++j) {
          const FacePoint point = project_to_cube(rays.at(i, j));
          linear.mark_linear(point);
          nearest.mark_nearest(point);
        }
      }
      mean.linear += static_cast<double>(linear.count());
      mean.nearest += static_cast<double>(nearest.count());
    }
  }
  constexpr double kViews = kHeadings.size() * kElevations.size();
  return {mean.linear / kViews, mean.nearest / kViews};
}

PictureTraffic picture_traffic(const Camera& camera, std::uint32_t face_size,
                               const render::Outputs& outputs, std::size_t views) {
  const TexelsSeen seen = texels_seen(camera, face_size);
  PictureTraffic traffic;
  double bytes = 0;
  if (outputs.colour) {
    traffic.texels += 3 * seen.linear;
    bytes += static_cast<double>(outputs.colour->pixels.size());
  }
  if (outputs.depth) {
    traffic.texels += 2 * seen.nearest;
    bytes += static_cast<double>(outputs.depth->pixels.size());
  }
  if (outputs.classes) {
    traffic.texels += 2 * seen.nearest;
    bytes += static_cast<double>(outputs.classes->pixels.size());
  }
  if (outputs.instances) {
    traffic.texels += 4 * seen.nearest;
    bytes += static_cast<double>(outputs.instances->pixels.size_bytes());
  }
  traffic.output = bytes / static_cast<double>(views);
  return traffic;
}

double memory_bound(const PictureTraffic& traffic, const MemoryRates& texels_in,
                    const MachineLimits& limits) {
  const double write = std::max({limits.cache.write, limits.cache.write_past_caches,
                                 limits.memory.write, limits.memory.write_past_caches});
  return traffic.texels / texels_in.read + traffic.output / write;
}

}  // namespace enfilade::bench
