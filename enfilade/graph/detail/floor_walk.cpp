#include "enfilade/graph/detail/floor_walk.h"

#include <algorithm>
#include <numeric>
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
    std::vector<std::uint32_t> sides;
    for (const std::uint32_t n : floor_.neighbours(c)) {
      if (parent_[n] != kNone) sides.push_back(root(n));
    }
    std::ranges::sort(sides, [&](auto a, auto b) { return wider(a, b); });
    const double here = half_width(c);
    for (const std::uint32_t side : sides) {
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
};

}  // namespace

void WalkingDistances::add(std::uint32_t cell, double limit) {
  Queue open;
  open.emplace(0, cell);
  metres_[cell] = 0;
  while (!open.empty()) {
    const auto [far, at] = open.top();
    open.pop();
    if (far > metres_[at]) continue;
    for (const std::uint32_t next : floor_.neighbours(at)) {
      const double metres = far + apart(floor_, at, next);
      if (metres >= metres_[next] || metres > limit) continue;
      metres_[next] = metres;
      open.emplace(metres, next);
    }
  }
}

std::vector<std::uint32_t> find_way(const mesh::WalkableFloor& floor,
                                    const std::vector<std::uint32_t>& from,
                                    const std::vector<std::uint32_t>& to) {
  constexpr double kRoomy = 0.4;  // metres; more clearance makes a way no better
  std::vector<double> cost(floor.cells().size(), WalkingDistances::kFar);
  std::vector<std::uint32_t> before(cost.size(), kNone);
  std::vector<char> goal(cost.size(), 0);
  for (const std::uint32_t c : to) goal[c] = 1;
  Queue open;
  for (const std::uint32_t c : from) open.emplace(cost[c] = 0, c);
  while (!open.empty()) {
    const auto [far, at] = open.top();
    open.pop();
    if (far > cost[at]) continue;
    if (goal[at]) {
      std::vector<std::uint32_t> way;
      for (std::uint32_t c = at; c != kNone; c = before[c]) way.push_back(c);
      std::ranges::reverse(way);
      return way;
    }
    for (const std::uint32_t next : floor.neighbours(at)) {
      const double tight = std::max(0.0, kRoomy - floor.cells()[next].clearance) / kRoomy;
      const double price = far + apart(floor, at, next) * (1 + 2 * tight);
      if (price >= cost[next]) continue;
      cost[next] = price;
      before[next] = at;
      open.emplace(price, next);
    }
  }
  return {};
}

Pockets find_pockets(const mesh::WalkableFloor& floor) { return Flood(floor).run(); }

}  // namespace enfilade::graph::detail
