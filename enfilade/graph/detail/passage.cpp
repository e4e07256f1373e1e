#include "enfilade/graph/detail/passage.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace enfilade::graph::detail {
namespace {

// A way is bent where the floor leaves the straight line by more: treads are under half of that.
constexpr double kStraight = 0.15;

void check_options(const EdgeOptions& o) {
  check_range("longest", o.longest, 0.1, 1000);
  check_range("width", o.width, 0, 5);
  check_range("lowest", o.lowest, 0, 10);
  check_range("highest", o.highest, o.lowest, 10);
  check_range("columns", o.columns, 1, 64);
  check_range("rows", o.rows, 1, 64);
}

Vec3d between(Vec3d a, Vec3d b, double share) { return a + share * (b - a); }

// Keeps the corners of a profile (Douglas and Peucker), heights only: it is straight in plan.
void add_corners(const std::vector<Vec3d>& profile, std::size_t first, std::size_t last,
                 std::vector<Vec3d>& out) {
  std::size_t worst = first;
  double most = kStraight;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double share = static_cast<double>(i - first) / static_cast<double>(last - first);
    const double off = std::abs(profile[i].z - between(profile[first], profile[last], share).z);
    if (off > most) {
      most = off;
      worst = i;
    }
  }
  if (worst != first) {
    add_corners(profile, first, worst, out);
    add_corners(profile, worst, last, out);
  } else {
    out.push_back(profile[last]);
  }
}

double at(double low, double high, std::uint32_t i, std::uint32_t count) {
  return count == 1 ? (low + high) / 2 : low + (high - low) * i / (count - 1);
}

Vec3d floor_below(const PlacedViewpoint& v) { return v.eye - Vec3d{0, 0, v.height}; }

}  // namespace

Passage::Passage(const mesh::RayTracer& tracer, const mesh::WalkableFloor& floor,
                 const EdgeOptions& options)
    : tracer_(tracer), floor_(floor), options_(options) {
  check_options(options);
}

bool Passage::in_sight(const PlacedViewpoint& a, const PlacedViewpoint& b) const {
  return tracer_.sees(to_float(a.eye), to_float(b.eye));
}

bool Passage::is_free(const PlacedViewpoint& a, const PlacedViewpoint& b) const {
  const double apart = length(b.eye - a.eye);
  if (!(apart > 0 && apart <= options_.longest) || !in_sight(a, b)) return false;
  const Vec3d from = floor_below(a), to = floor_below(b);
  std::vector<Vec3d> profile{from, to};
  if (options_.need_floor) profile = floor_profile(from, to);
  if (profile.empty()) return false;
  std::vector<Vec3d> way{profile.front()};
  add_corners(profile, 0, profile.size() - 1, way);
  return has_room(way);
}

// Follows the floor from a to b, a cell at a time. Empty if floor is missing or a step is too high.
// The body's middle may be as far outside the cells as the floor's body is wider than the edge's:
// the rays check the rest.
std::vector<Vec3d> Passage::floor_profile(Vec3d a, Vec3d b) const {
  const mesh::WalkableOptions& walk = floor_.options();
  const double step = walk.body.step + 0.02;  // treads of real stairs vary by this much
  const double flat = std::hypot(b.x - a.x, b.y - a.y);
  const auto pieces = static_cast<std::size_t>(std::max(1.0, std::ceil(flat / walk.cell)));
  const double aside = std::max(0.0, walk.body.radius - options_.width / 2) + walk.cell / 2;
  const Vec3d right = flat > 0 ? Vec3d{aside * (b.y - a.y) / flat, aside * (a.x - b.x) / flat, 0}
                               : Vec3d{aside, 0, 0};
  std::vector<Vec3d> profile{a};
  for (std::size_t i = 1; i <= pieces; ++i) {
    Vec3d p = between(a, b, static_cast<double>(i) / static_cast<double>(pieces));
    p.z = profile.back().z + step;
    std::optional<std::size_t> cell = floor_.below(to_float(p), 2 * step);
    if (!cell) cell = floor_.below(to_float(p + right), 2 * step);
    if (!cell) cell = floor_.below(to_float(p - right), 2 * step);
    if (!cell) return {};
    p.z = floor_.cells()[*cell].position.z;
    profile.push_back(p);
  }
  if (std::abs(profile.back().z - b.z) > step) return {};
  return profile;
}

bool Passage::has_room(const std::vector<Vec3d>& way) const {
  const Vec3d whole = way.back() - way.front();
  const double flat = std::hypot(whole.x, whole.y);
  const Vec3d right = flat > 0 ? Vec3d{whole.y / flat, -whole.x / flat, 0} : Vec3d{1, 0, 0};
  const double half = options_.width / 2;
  std::vector<mesh::Ray> rays;
  for (std::size_t i = 1; i < way.size(); ++i) {
    for (std::uint32_t c = 0; c < options_.columns; ++c) {
      const double side = at(-half, half, c, options_.columns);
      for (std::uint32_t r = 0; r < options_.rows; ++r) {
        const Vec3d shift{side * right.x, side * right.y,
                          at(options_.lowest, options_.highest, r, options_.rows)};
        rays.push_back({to_float(way[i - 1] + shift), to_float(way[i] - way[i - 1]), 0, 1});
      }
    }
  }
  std::vector<std::uint8_t> blocked(rays.size());
  tracer_.blocked(rays, blocked);
  return std::ranges::count(blocked, std::uint8_t{0}) == std::ssize(blocked);
}

}  // namespace enfilade::graph::detail
