#include "enfilade/homes/instructions/speaker.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "enfilade/core/threads.h"
#include "enfilade/geometry/angle.h"

namespace enfilade::homes::instructions {
namespace {

constexpr std::uint32_t kFewestRays = 3;
constexpr std::size_t kNoThing = static_cast<std::size_t>(-1);

// A Fibonacci lattice, sorted so that neighbours lie together, as rays are traced in packets: in
// bands of equal height, and around each band.
std::vector<Vec3f> directions(std::size_t count) {
  const auto n = static_cast<double>(count);
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  const auto bands = std::max<std::size_t>(1, static_cast<std::size_t>(std::sqrt(n) / 2));
  struct Keyed {
    std::size_t band;
    double around;
    Vec3f direction;
  };
  std::vector<Keyed> all;
  all.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / n;
    const double radius = std::sqrt(1 - z * z);
    const double around = std::fmod(golden * static_cast<double>(i), 2 * std::numbers::pi);
    all.push_back({i * bands / count,
                   around,
                   {static_cast<float>(radius * std::cos(around)),
                    static_cast<float>(radius * std::sin(around)), static_cast<float>(z)}});
  }
  std::ranges::sort(all, {}, [](const Keyed& one) { return std::pair(one.band, one.around); });
  std::vector<Vec3f> sorted;
  sorted.reserve(count);
  for (const Keyed& one : all) sorted.push_back(one.direction);
  return sorted;
}

// The thing of each object.
std::vector<std::size_t> things_of_objects(const Home& home) {
  std::vector<std::size_t> things(home.mesh.objects.size(), kNoThing);
  for (std::size_t i = 0; i < home.things.size(); ++i) {
    const std::uint32_t object = home.things[i].object;
    if (object < things.size()) things[object] = i;
  }
  return things;
}

// The rays that hit one thing.
struct Sum {
  std::uint32_t rays = 0;
  Vec3d direction;
  double distance = 0;
};

std::vector<ThingInView> sights_of(const std::vector<Sum>& sums, std::size_t rays) {
  std::vector<ThingInView> found;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const Sum& sum = sums[i];
    if (sum.rays < kFewestRays) continue;
    const double level = std::hypot(sum.direction.x, sum.direction.y);
    found.push_back({i, wrap_heading(Radians(std::atan2(sum.direction.x, sum.direction.y))).value,
                     std::atan2(sum.direction.z, level), sum.distance / sum.rays,
                     static_cast<double>(sum.rays) / static_cast<double>(rays)});
  }
  std::ranges::stable_sort(found, std::ranges::greater(), &ThingInView::share);
  return found;
}

// Finds the things that are visible from a point.
class Looker {
 public:
  Looker(const Home& home, const mesh::RayTracer& tracer, std::size_t rays)
      : tracer_(tracer),
        things_(things_of_objects(home)),
        count_(home.things.size()),
        directions_(directions(rays)) {}

  std::vector<ThingInView> from(Vec3f eye) const {
    std::vector<mesh::Ray> rays;
    rays.reserve(directions_.size());
    for (const Vec3f direction : directions_) rays.push_back({eye, direction});
    std::vector<mesh::Hit> hits(rays.size());
    tracer_.trace(rays, hits);
    std::vector<Sum> sums(count_);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const std::size_t thing = thing_at(hits[i]);
      if (thing == kNoThing) continue;
      sums[thing].direction += to_double(directions_[i]);
      sums[thing].distance += static_cast<double>(hits[i].distance);
      ++sums[thing].rays;
    }
    return sights_of(sums, hits.size());
  }

 private:
  std::size_t thing_at(const mesh::Hit& hit) const {
    const std::vector<std::uint32_t>& objects = tracer_.mesh().triangle_object;
    if (!hit || objects.empty()) return kNoThing;
    const std::uint32_t object = objects[hit.triangle];
    return object < things_.size() ? things_[object] : kNoThing;
  }

  const mesh::RayTracer& tracer_;
  std::vector<std::size_t> things_;
  std::size_t count_;
  std::vector<Vec3f> directions_;
};

}  // namespace

ThingsInView::ThingsInView(const Home& home, const mesh::RayTracer& tracer,
                           const graph::NavGraph& graph, std::size_t rays, int threads)
    : sights_(graph.size()), rooms_(graph.size()) {
  const Looker looker(home, tracer, rays);
  parallel_for(graph.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ViewpointIndex v(i);
      if (!graph.included(v)) continue;
      sights_[i] = looker.from(graph.position(v));
      Vec3d foot = to_double(graph.position(v));
      foot.z -= static_cast<double>(graph.height(v));
      rooms_[i] = room_at(home.plan, foot);
    }
  });
}

}  // namespace enfilade::homes::instructions
