#include "tests/support/home_passage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace enfilade::tests {
namespace {

using namespace homes;

using Interval = std::pair<double, double>;  // of metres along the way

// A way in plan.
struct Way {
  double x = 0, y = 0;              // its start
  double along_x = 1, along_y = 0;  // direction, length 1
  double length = 0;
};

// A stretch of floor along a way.
struct Floor {
  Interval at;
  double z = 0, slope = 0;  // height where at begins; metres up a metre
  double z_at(double s) const { return z + slope * (s - at.first); }
};

struct Point {
  double s = 0, n = 0;  // along the way; to its left
};
using Polygon = std::vector<Point>;

// The part of a polygon on one side of a line n = limit.
Polygon clipped(const Polygon& polygon, double limit, bool below) {
  Polygon out;
  const auto inside = [&](const Point& p) { return below ? p.n <= limit : p.n >= limit; };
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    if (inside(p)) out.push_back(p);
    if (inside(p) == inside(q)) continue;
    const double t = (limit - p.n) / (q.n - p.n);
    out.push_back({p.s + t * (q.s - p.s), limit});
  }
  return out;
}

// Where along the way a body `half` wide on either side is beside an obstacle's outline.
std::optional<Interval> beside(const Way& way, const Obstacle& o, double half) {
  const double c = std::cos(o.turned), s = std::sin(o.turned);
  Polygon outline;
  for (const auto& [i, j] :
       std::array<std::pair<int, int>, 4>{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}}) {
    const double x = o.x + c * o.half_x * i - s * o.half_y * j - way.x;
    const double y = o.y + s * o.half_x * i + c * o.half_y * j - way.y;
    outline.push_back({x * way.along_x + y * way.along_y, y * way.along_x - x * way.along_y});
  }
  outline = clipped(clipped(outline, half, true), -half, false);
  if (outline.empty()) return std::nullopt;
  Interval at{outline[0].s, outline[0].s};
  for (const Point& p : outline) {
    at = {std::min(at.first, p.s), std::max(at.second, p.s)};
  }
  return at;
}

bool blocks(const Way& way, const Floor& floor, const Obstacle& o, double half, double lowest,
            double highest, double slack) {
  auto at = beside(way, o, half);
  if (!at) return false;
  at->first = std::max(at->first, floor.at.first);
  at->second = std::min(at->second, floor.at.second);
  if (at->first > at->second) return false;
  // Heights of the floor at which the body would meet it.
  const double low = o.z0 - (highest - slack), high = o.z1 - (lowest + slack);
  const double z0 = floor.z_at(at->first), z1 = floor.z_at(at->second);
  return std::max(z0, z1) > low && std::min(z0, z1) < high;
}

// Where a way is within a rectangle; nothing if nowhere.
std::optional<Interval> within(const Way& way, const Rect& r) {
  Interval at{0, way.length};
  const auto clip = [&](double start, double step, double low, double high) {
    if (std::abs(step) < 1e-12) {
      if (start < low || start > high) at.second = -1;
      return;
    }
    const double a = (low - start) / step, b = (high - start) / step;
    at = {std::max(at.first, std::min(a, b)), std::min(at.second, std::max(a, b))};
  };
  clip(way.x, way.along_x, r.x0, r.x1);
  clip(way.y, way.along_y, r.y0, r.y1);
  if (at.first > at.second) return std::nullopt;
  return at;
}

// Parts of the way on floors of rooms and of doorways, but not on the holes of stairs.
void add_level_floors(const Plan& plan, const Way& way, std::vector<Floor>& floors) {
  const auto add = [&](const Rect& rect, unsigned storey) {
    const auto at = within(way, rect);
    if (!at) return;
    std::vector<Interval> parts{*at};
    for (const Stairs& s : plan.stairs) {
      if (s.storey + 1 != storey) continue;
      const auto hole = within(way, s.flight);
      if (!hole) continue;
      std::vector<Interval> rest;
      for (const auto& [a, b] : parts) {
        if (hole->first > a) rest.emplace_back(a, std::min(b, hole->first));
        if (hole->second < b) rest.emplace_back(std::max(a, hole->second), b);
      }
      parts = std::move(rest);
    }
    for (const Interval& part : parts) floors.push_back({part, plan.storeys[storey].floor, 0});
  };
  for (const PlanRoom& room : plan.rooms) add(room.floor, room.storey);
  for (const Opening& o : plan.openings) {
    if (o.kind != OpeningKind::kDoor && o.kind != OpeningKind::kArch) continue;
    const double half = plan.inner_wall / 2;
    add(laid_rect(o.along_x, o.from, o.to, o.wall - half, o.wall + half),
        plan.rooms[o.room0].storey);
  }
}

void add_flights(const Plan& plan, const Way& way, std::vector<Floor>& floors) {
  for (const Stairs& s : plan.stairs) {
    const auto at = within(way, s.flight);
    if (!at) continue;
    const bool x = faces_x(s.climbs_towards), up = is_high(s.climbs_towards);
    const double run = s.flight.length(x), foot = s.flight.at(opposite(s.climbs_towards));
    const double rate = plan.storeys[s.storey].height / run * (up ? 1 : -1);
    const double step = x ? way.along_x : way.along_y;
    const double enters = (x ? way.x : way.y) + at->first * step;
    floors.push_back({*at, plan.storeys[s.storey].floor + rate * (enters - foot), rate * step});
  }
}

// The floor that a body is on from start to end, stretch by stretch; empty if there is a gap, or a
// step that is too high. Where two floors are within reach, as at the foot of a flight, the higher.
std::vector<Floor> walked_floor(const Plan& plan, const Way& way, double from_z, double to_z) {
  constexpr double kGap = 1e-6;  // rounding where floors meet
  constexpr double kStep = 0.35;
  std::vector<Floor> all, walked;
  add_level_floors(plan, way, all);
  add_flights(plan, way, all);
  std::vector<double> cuts{0, way.length};
  for (const Floor& floor : all) cuts.insert(cuts.end(), {floor.at.first, floor.at.second});
  std::sort(cuts.begin(), cuts.end());
  double z = from_z;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const Interval at{cuts[i], cuts[i + 1]};
    if (at.second - at.first < kGap) continue;
    const Floor* best = nullptr;
    for (const Floor& floor : all) {
      if (floor.at.first > at.first + kGap || floor.at.second < at.second - kGap) continue;
      if (std::abs(floor.z_at(at.first) - z) > kStep) continue;
      if (best == nullptr || floor.z_at(at.second) > best->z_at(at.second)) best = &floor;
    }
    if (best == nullptr) return {};
    walked.push_back({at, best->z_at(at.first), best->slope});
    z = walked.back().z_at(at.second);
  }
  if (std::abs(z - to_z) > kStep) return {};
  return walked;
}

}  // namespace

bool passage_is_free(const Home& home, Vec3d a, Vec3d b, double width, double lowest,
                     double highest, double slack) {
  Way way{a.x, a.y, 1, 0, std::hypot(b.x - a.x, b.y - a.y)};
  if (way.length > 0) {
    way.along_x = (b.x - a.x) / way.length;
    way.along_y = (b.y - a.y) / way.length;
  }
  const std::vector<Floor> floors = walked_floor(home.plan, way, a.z, b.z);
  if (floors.empty()) return false;
  const double half = std::max(0.0, width / 2 - slack);
  return std::none_of(home.obstacles.begin(), home.obstacles.end(), [&](const Obstacle& o) {
    return std::any_of(floors.begin(), floors.end(), [&](const Floor& floor) {
      return blocks(way, floor, o, half, lowest, highest, slack);
    });
  });
}

}  // namespace enfilade::tests
