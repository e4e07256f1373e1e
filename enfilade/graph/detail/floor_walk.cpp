#include "enfilade/graph/detail/floor_walk.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <queue>
#include <utility>

namespace enfilade::graph::detail {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
using Place = std::pair<double, std::uint32_t>;  // distance, cell: equal ones by the lower index
using Queue = std::priority_queue<Place, std::vector<Place>, std::greater<>>;

double apart(const mesh::WalkableFloor& floor, std::uint32_t a, std::uint32_t b) {
  return length(floor.cells()[a].position - floor.cells()[b].position);
}

constexpr double kPassage = 0.55;  // largest half width of a passage between two rooms
constexpr double kWider = 1.3;     // a room is wider than its door by this, at least
constexpr double kRoom = 0.5;      // m2 where the body's middle may be: 1.5 m2 of floor

// Grows pockets from their middles outwards until they meet.
class Flood {
 public:
  explicit Flood(const mesh::WalkableFloor& floor)
      : floor_(floor), parent_(floor.cells().size(), kNone), size_(parent_.size(), 0) {}

  Pockets run() {
    const auto cells = floor_.cells();
    std::vector<std::uint32_t> order(cells.size());
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, std::greater<>{},
                             [&](std::uint32_t c) { return cells[c].clearance; });
    for (const std::uint32_t c : order) flood(c);
    // Short ways to the roots, for the cells are met in no order of memory.
    for (std::uint32_t c = 0; c < parent_.size(); ++c) parent_[c] = root(c);
    for (const std::uint32_t c : order) merge_small(c);
    return number();
  }

 private:
  // A pocket is known by its widest cell.
  std::uint32_t root(std::uint32_t c) {
    while (parent_[c] != c) c = parent_[c] = parent_[parent_[c]];
    return c;
  }
  double half_width(std::uint32_t c) const {
    return floor_.cells()[c].clearance + floor_.options().body.radius;
  }
  bool wider(std::uint32_t a, std::uint32_t b) const {
    return std::pair(half_width(a), b) > std::pair(half_width(b), a);
  }

  void join(std::uint32_t a, std::uint32_t b) {
    if (wider(b, a)) std::swap(a, b);
    parent_[b] = a;
    size_[a] += size_[b];
  }

  void flood(std::uint32_t c) {
    parent_[c] = c;
    size_[c] = 1;
    // Widest first, so that the cell of a door joins one side and the sides stay separate.
    sides_.clear();
    for (const std::uint32_t n : floor_.neighbours(c)) {
      if (parent_[n] == kNone) continue;
      const std::uint32_t side = root(n);
      if (std::ranges::find(sides_, side) == sides_.end()) sides_.push_back(side);
    }
    std::ranges::sort(sides_, [&](auto a, auto b) { return wider(a, b); });
    const double here = half_width(c);
    for (const std::uint32_t side : sides_) {
      const std::uint32_t a = root(c), b = root(side);
      if (a == b) continue;
      const bool door =
          here < kPassage && half_width(a) > kWider * here && half_width(b) > kWider * here;
      if (!door) join(a, b);
    }
  }

  // A pocket that is too small for a room joins its neighbour.
  void merge_small(std::uint32_t c) {
    const double cell = floor_.options().cell * floor_.options().cell;
    for (const std::uint32_t n : floor_.neighbours(c)) {
      const std::uint32_t a = root(c), b = root(n);
      if (a != b && std::min(size_[a], size_[b]) * cell < kRoom) join(a, b);
    }
  }

  Pockets number() {
    Pockets pockets{std::vector<std::uint32_t>(parent_.size(), kNone), 0};
    std::vector<std::uint32_t> names(parent_.size(), kNone);
    for (std::uint32_t c = 0; c < parent_.size(); ++c) {
      std::uint32_t& name = names[root(c)];
      if (name == kNone) name = pockets.count++;
      pockets.of[c] = name;
    }
    return pockets;
  }

  const mesh::WalkableFloor& floor_;
  std::vector<std::uint32_t> parent_, size_;
  std::vector<std::uint32_t> sides_;  // roots of the neighbours of one cell
};

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

void WalkingDistances::add(std::uint32_t cell, double limit) {
  Queue open;
  const auto reach = [&](std::uint32_t at, double metres) {
    if (metres_[at] == kFar) reached_.push_back(at);
    metres_[at] = metres;
    open.emplace(metres, at);
  };
  reach(cell, 0);
  while (!open.empty()) {
    const auto [far, at] = open.top();
    open.pop();
    if (far > metres_[at]) continue;
    for (const std::uint32_t next : floor_.neighbours(at)) {
      const double metres = far + apart(floor_, at, next);
      if (metres >= metres_[next] || metres > limit) continue;
      reach(next, metres);
    }
  }
}

void WalkingDistances::clear() {
  for (const std::uint32_t cell : reached_) metres_[cell] = kFar;
  reached_.clear();
}

void WaySearch::set(std::uint32_t cell, double cost, std::uint32_t before) {
  if (cost_[cell] == WalkingDistances::kFar) visited_.push_back(cell);
  cost_[cell] = cost;
  before_[cell] = before;
}

std::vector<std::uint32_t> WaySearch::find(const std::vector<std::uint32_t>& from,
                                           const std::vector<std::uint32_t>& to) {
  for (const std::uint32_t c : to) goal_[c] = 1;
  std::vector<std::uint32_t> way = search(from);
  for (const std::uint32_t c : to) goal_[c] = 0;
  for (const std::uint32_t c : visited_) cost_[c] = WalkingDistances::kFar;
  visited_.clear();
  return way;
}

std::vector<std::uint32_t> WaySearch::search(const std::vector<std::uint32_t>& from) {
  constexpr double kRoomy = 0.4;  // metres; more clearance makes a way no better
  Queue open;
  for (const std::uint32_t c : from) {
    set(c, 0, kNone);
    open.emplace(0, c);
  }
  while (!open.empty()) {
    const auto [far, at] = open.top();
    open.pop();
    if (far > cost_[at]) continue;
    if (goal_[at]) {
      std::vector<std::uint32_t> way;
      for (std::uint32_t c = at; c != kNone; c = before_[c]) way.push_back(c);
      std::ranges::reverse(way);
      return way;
    }
    for (const std::uint32_t next : floor_.neighbours(at)) {
      const double tight = std::max(0.0, kRoomy - floor_.cells()[next].clearance) / kRoomy;
      const double price = far + apart(floor_, at, next) * (1 + 2 * tight);
      if (price >= cost_[next]) continue;
      set(next, price, at);
      open.emplace(price, next);
    }
  }
  return {};
}

Pockets find_pockets(const mesh::WalkableFloor& floor) { return Flood(floor).run(); }

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
