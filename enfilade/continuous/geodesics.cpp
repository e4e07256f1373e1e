#include "enfilade/continuous/geodesics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "enfilade/continuous/detail/sight.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"

namespace enfilade::continuous {

using namespace detail;

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kNone = 0xffffffffU;
// Sines below this are 0: the direction along a wall, from a point on it up to single precision.
// More bends than needed cost time, not length.
constexpr double kAlong = 1e-3;

// A corner of the rim with more than half a turn of floor around it, and its two walls.
struct Bend {
  std::uint32_t corner = 0;
  Flat wall_out, wall_in;  // directions of length 1
  Flat place;              // where a string goes by

  // Whether a taut string can pass here in this direction: both walls are on one side of it.
  bool holds_string(Flat along) const {
    const double length = norm(along);
    const double out = turn(along, wall_out) / length, in = turn(along, wall_in) / length;
    return std::abs(out) < kAlong || std::abs(in) < kAlong || (out > 0) == (in > 0);
  }
};

// A straight line from one bend to another.
struct Line {
  std::uint32_t to = 0;
  double metres = 0;
};

struct Bends {
  std::vector<Bend> list;
  std::vector<std::uint32_t> of_corner;  // kNone: it is no bend
  std::vector<Line> lines;
  std::vector<std::uint32_t> first_line;

  std::span<const Line> lines_of(std::uint32_t bend) const {
    return std::span(lines).subspan(first_line[bend], first_line[bend + 1] - first_line[bend]);
  }
};

Flat unit(Flat a) {
  const double length = norm(a);
  return {a.x / length, a.y / length};
}

// The floor around a corner from one wall to the next, counter-clockwise.
class Fans {
 public:
  Fans(const FlatFloor& floor, std::uint32_t corner, double radius)
      : floor_(floor), corner_(corner), radius_(radius) {}

  std::optional<Bend> bend() const {
    for (const std::uint32_t polygon : floor_.around(corner_)) {
      const auto [next, before, beyond_next, beyond_before] = at(polygon);
      if (beyond_next != FlatFloor::kRim) continue;
      if (const auto found = follow(polygon, next)) return found;
    }
    return std::nullopt;
  }

 private:
  struct Place {
    std::uint32_t next = 0, before = 0;                // the corners beside this one
    std::uint32_t beyond_next = 0, beyond_before = 0;  // across the two sides
  };

  Place at(std::uint32_t polygon) const {
    const auto sides = floor_.sides(polygon);
    const std::size_t n = sides.size();
    std::size_t k = 0;
    while (sides[k].corner != corner_) ++k;
    const FlatFloor::PolygonSide& before = sides[(k + n - 1) % n];
    return {sides[(k + 1) % n].corner, before.corner, sides[k].beyond, before.beyond};
  }

  std::optional<Bend> follow(std::uint32_t polygon, std::uint32_t first) const {
    const Flat here = floor_.corner(corner_);
    double angle = 0;
    for (std::size_t steps = 0; steps <= floor_.around(corner_).size(); ++steps) {
      const Place place = at(polygon);
      const Flat out = floor_.corner(place.next) - here, in = floor_.corner(place.before) - here;
      angle += std::atan2(turn(out, in), out.x * in.x + out.y * in.y);
      if (place.beyond_before != FlatFloor::kRim) {
        polygon = place.beyond_before;
        continue;
      }
      if (angle <= kPi + 1e-9) return std::nullopt;
      const Flat out_wall = unit(floor_.corner(first) - here), in_wall = unit(in);
      return Bend{corner_, out_wall, in_wall, rounded(here, out_wall, in_wall, angle - kPi)};
    }
    return std::nullopt;  // no wall: all around is floor
  }

  // The rim around a corner of a wall is an arc with the body's radius r, of which a polygon keeps
  // points. A way that turns by t at such a point would be shorter than along the arc: 2 r sin(t/2)
  // instead of r t. It is as long, where the point is moved away from the wall by the difference.
  Flat rounded(Flat here, Flat out_wall, Flat in_wall, double turned) const {
    const double away = radius_ * (turned / (2 * std::sin(turned / 2)) - 1);
    const Flat from_wall{-out_wall.x - in_wall.x, -out_wall.y - in_wall.y};
    const double length = norm(from_wall);
    if (length < 1e-9) return here;
    return {here.x + away / length * from_wall.x, here.y + away / length * from_wall.y};
  }

  const FlatFloor& floor_;
  std::uint32_t corner_;
  double radius_;
};

}  // namespace

struct Geodesics::Impl {
  std::shared_ptr<const NavigationMesh> mesh;
  FlatFloor floor;
  Bends bends;

  explicit Impl(std::shared_ptr<const NavigationMesh> of) : mesh(std::move(of)), floor(*mesh) {
    find_bends();
    find_lines();
  }

  void find_bends() {
    bends.of_corner.assign(floor.corners().size(), kNone);
    for (std::uint32_t c = 0; c < floor.corners().size(); ++c) {
      if (const auto bend = Fans(floor, c, mesh->floor().body.radius).bend()) {
        bends.of_corner[c] = static_cast<std::uint32_t>(bends.list.size());
        bends.list.push_back(*bend);
      }
    }
  }

  // Calls found(bend, offset of it from the eye) for those seen that a string from the eye holds.
  template <class Found>
  auto bend_finder(Flat eye, const Found& found) const {
    return [this, eye, &found](std::uint32_t polygon, const Cone& cone) {
      for (const FlatFloor::PolygonSide& side : floor.sides(polygon)) {
        const std::uint32_t bend = bends.of_corner[side.corner];
        if (bend == kNone) continue;
        const Flat to = floor.corner(side.corner) - eye;
        if (cone.holds(to) && bends.list[bend].holds_string(to)) found(bend);
      }
    };
  }

  double metres(Vec3d a, Vec3d b) const { return length(b - a); }
  Vec3d place(std::uint32_t bend) const {
    const Bend& b = bends.list[bend];
    return {b.place.x, b.place.y, floor.corners()[b.corner].z};
  }

  void find_lines() {
    std::vector<std::uint32_t> seen;
    for (std::uint32_t b = 0; b < bends.list.size(); ++b) {
      bends.first_line.push_back(static_cast<std::uint32_t>(bends.lines.size()));
      seen.clear();
      const Bend& bend = bends.list[b];
      const Flat eye = floor.corner(bend.corner);
      const auto found = [&](std::uint32_t other) {
        if (other != b && bend.holds_string(floor.corner(bends.list[other].corner) - eye)) {
          seen.push_back(other);
        }
      };
      const auto visit = bend_finder(eye, found);
      FloorSight(floor, eye, visit).look_around(bend.corner);
      std::ranges::sort(seen);
      seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
      for (const std::uint32_t other : seen) {
        bends.lines.push_back({other, metres(place(b), place(other))});
      }
    }
    bends.first_line.push_back(static_cast<std::uint32_t>(bends.lines.size()));
  }
};

namespace {

// Costs and the order in which bends are looked at. Kept by each thread, so that questions allocate
// nothing once a thread has seen the largest building.
struct Search {
  std::vector<double> cost, rest;  // metres from the start; metres to the goal if it is seen
  std::vector<std::uint32_t> before;
  std::vector<std::pair<double, std::uint32_t>> open;

  void begin(std::size_t bends) {
    cost.assign(bends, kFar);
    rest.assign(bends, kFar);
    before.assign(bends, kNone);
    open.clear();
  }
  void reach(std::uint32_t bend, double metres, std::uint32_t from, double guess) {
    if (!(metres < cost[bend])) return;
    cost[bend] = metres;
    before[bend] = from;
    open.emplace_back(metres + guess, bend);
    std::ranges::push_heap(open, std::greater<>{});
  }
  std::pair<double, std::uint32_t> next() {
    std::ranges::pop_heap(open, std::greater<>{});
    const auto found = open.back();
    open.pop_back();
    return found;
  }
};

Search& own_search() {
  thread_local Search search;
  return search;
}

struct Found {
  double metres = kFar;
  std::uint32_t last = kNone;  // the bend before the goal; kNone: straight
};

}  // namespace

namespace {

// The shortest way from a to b over bends; fills the thread's Search.
template <class Impl>
Found search(const Impl& own, const FloorPoint& a, const FloorPoint& b) {
  const Vec3d start = to_double(a.point), goal = to_double(b.point);
  const Flat from = flat(a.point), to = flat(b.point);
  Search& search = own_search();
  search.begin(own.bends.list.size());
  Found best;
  const auto from_start = [&](std::uint32_t bend) {
    search.reach(bend, own.metres(start, own.place(bend)), kNone,
                 own.metres(own.place(bend), goal));
  };
  const auto bends_from_start = own.bend_finder(from, from_start);
  const auto visit_start = [&](std::uint32_t polygon, const Cone& cone) {
    if (polygon == b.polygon && cone.holds(to - from)) best.metres = own.metres(start, goal);
    bends_from_start(polygon, cone);
  };
  FloorSight(own.floor, from, visit_start).look_from(a.polygon);
  if (best.metres < kFar) return best;  // nothing is shorter than straight
  const auto to_goal = [&](std::uint32_t bend) {
    search.rest[bend] = own.metres(own.place(bend), goal);
  };
  const auto visit_goal = own.bend_finder(to, to_goal);
  FloorSight(own.floor, to, visit_goal).look_from(b.polygon);
  while (!search.open.empty()) {
    const auto [guess, bend] = search.next();
    if (guess >= best.metres) break;
    const double here = search.cost[bend];
    if (guess > here + own.metres(own.place(bend), goal)) continue;  // reached shorter since
    if (here + search.rest[bend] < best.metres) best = {here + search.rest[bend], bend};
    for (const auto& line : own.bends.lines_of(bend)) {
      search.reach(line.to, here + line.metres, bend, own.metres(own.place(line.to), goal));
    }
  }
  return best;
}

}  // namespace

Geodesics::Geodesics(std::shared_ptr<const NavigationMesh> mesh) {
  if (!mesh) throw ArgumentError("mesh: null, not a navigation mesh");
  impl_ = std::make_shared<const Impl>(std::move(mesh));
}

const NavigationMesh& Geodesics::mesh() const noexcept { return *impl_->mesh; }
std::size_t Geodesics::areas() const noexcept { return mesh().areas(); }
double Geodesics::area_m2(std::size_t area) const { return mesh().area_m2(area); }
const mesh::FloorPolygons& Geodesics::polygons() const noexcept { return mesh().floor(); }

std::optional<FloorPoint> Geodesics::nearest(Vec3f point, Reach reach) const {
  return mesh().nearest(point, reach);
}

std::size_t Geodesics::area_of(const FloorPoint& at) const {
  EN_CHECK_LT(at.polygon, polygons().polygons.size());
  return polygons().polygons[at.polygon].area;
}

FloorPoint Geodesics::random_point(Rng& rng, std::optional<std::uint32_t> area) const {
  return mesh().random_point(rng, area);
}

Walked Geodesics::move(Walker& walker, const FloorPoint& from, Vec3d by, Walls walls) const {
  const Vec3f towards{static_cast<float>(from.point.x + by.x),
                      static_cast<float>(from.point.y + by.y), from.point.z};
  return mesh().walk(walker, from, towards, walls);
}

std::size_t Geodesics::bends() const noexcept { return impl_->bends.list.size(); }

double Geodesics::distance(const FloorPoint& a, const FloorPoint& b) const {
  return search(*impl_, a, b).metres;
}

std::optional<std::vector<Vec3f>> Geodesics::path(const FloorPoint& a, const FloorPoint& b) const {
  const Found found = search(*impl_, a, b);
  if (found.metres == kFar) return std::nullopt;
  std::vector<Vec3f> path{b.point};
  const Search& search = own_search();
  for (std::uint32_t bend = found.last; bend != kNone; bend = search.before[bend]) {
    path.push_back(to_float(impl_->place(bend)));
  }
  path.push_back(a.point);
  std::ranges::reverse(path);
  return path;
}

struct Geodesics::Goals final : DistanceField::Goals {
  std::shared_ptr<const Impl> building;
  std::vector<FloorPoint> goals;
  std::vector<double> to_goal;  // metres from each bend

  std::optional<DistanceField::Way> way(const FloorPoint& from) const override;
};

DistanceField Geodesics::field(std::span<const FloorPoint> goals) const {
  if (goals.empty()) throw ArgumentError("goals: none, at least one");
  auto field = std::make_shared<Goals>();
  field->building = impl_;
  field->goals.assign(goals.begin(), goals.end());
  Search& search = own_search();
  search.begin(impl_->bends.list.size());
  for (const FloorPoint& goal : goals) {
    const auto found = [&](std::uint32_t bend) {
      search.reach(bend, impl_->metres(to_double(goal.point), impl_->place(bend)), kNone, 0);
    };
    const auto visit = impl_->bend_finder(flat(goal.point), found);
    FloorSight(impl_->floor, flat(goal.point), visit).look_from(goal.polygon);
  }
  while (!search.open.empty()) {
    const auto [metres, bend] = search.next();
    if (metres > search.cost[bend]) continue;
    for (const Line& line : impl_->bends.lines_of(bend)) {
      search.reach(line.to, metres + line.metres, bend, 0);
    }
  }
  field->to_goal = search.cost;
  return DistanceField(std::move(field));
}

std::optional<DistanceField::Way> Geodesics::Goals::way(const FloorPoint& from) const {
  const Impl& own = *building;
  const Vec3d start = to_double(from.point);
  const Flat eye = flat(from.point);
  DistanceField::Way best{kFar, {}};
  const auto bend = [&](std::uint32_t b) {
    const Vec3d place = own.place(b);
    const double metres = own.metres(start, place) + to_goal[b];
    // A bend where one stands is no direction to walk in; those that it sees are seen from here.
    if (metres < best.metres && norm(Flat{place.x, place.y} - eye) > Cone::kSlack) {
      best = {metres, to_float(place)};
    }
  };
  const auto bends = own.bend_finder(eye, bend);
  const auto visit = [&](std::uint32_t polygon, const Cone& cone) {
    for (const FloorPoint& goal : goals) {
      if (goal.polygon != polygon || !cone.holds(flat(goal.point) - eye)) continue;
      const double metres = own.metres(start, to_double(goal.point));
      if (metres <= best.metres) best = {metres, goal.point};
    }
    bends(polygon, cone);
  };
  FloorSight(own.floor, eye, visit).look_from(from.polygon);
  if (best.metres == kFar) return std::nullopt;
  return best;
}

double DistanceField::distance(const FloorPoint& from) const {
  const auto found = way(from);
  return found ? found->metres : kFar;
}

}  // namespace enfilade::continuous
