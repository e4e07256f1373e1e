#include "enfilade/homes/small_building.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "enfilade/core/rng.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::homes {
namespace {

// All in metres. The house is three bays wide; a hallway runs along x through its middle (y = 0),
// with a room on either side of it in each bay. Behind the hallway, one bay holds the stairs.
constexpr double kEyeHeight = 1.5;
constexpr double kLongestEdge = 5.0;
constexpr double kHallway = 1.0;   // half its width
constexpr double kDoor = 0.45;     // half the width of a door
constexpr double kOpening = 0.8;   // half the width of an opening between two rooms
constexpr double kBody = 0.2;      // what a walker keeps clear of door posts
constexpr double kFromDoor = 1.0;  // from a door to the viewpoint inside
constexpr double kJitter = 0.1;
constexpr std::size_t kBays = 3;
constexpr std::size_t kStoreys = 2;

// A wall along x (or y) at the given place of the other axis, from one end to the other.
struct Wall {
  bool along_x = true;
  double at = 0, from = 0, to = 0;
};

struct Bay {
  double west = 0, east = 0;
  double door = 0;  // x of its doors to the hallway, both sides
};

// One viewpoint; stairs are on no storey.
struct Stand {
  Vec3d point;
  std::size_t storey = 0;
  bool stairs = false;
};

class Builder {
 public:
  Builder(std::uint64_t seed, std::string scan) : rng_(seed, stream_of("house", 5)), seed_(seed) {
    building_.connectivity.scan = std::move(scan);
    building_.connectivity.file = building_.connectivity.scan + "_connectivity.json";
  }

  SmallBuilding run() {
    plan_bays();
    std::array<std::size_t, kStoreys> foot{};  // the viewpoints of the hallways beside the stairs
    for (std::size_t storey = 0; storey < kStoreys; ++storey) {
      walls_[storey] = plan_walls(storey);
      foot[storey] = add_hallway(storey);
      add_rooms(storey);
    }
    connect_by_sight();
    add_stairs(foot);
    finish();
    return std::move(building_);
  }

 private:
  double between(double low, double high) { return low + (high - low) * rng_.uniform(); }

  void plan_bays() {
    stair_bay_ = rng_.below(kBays);
    front_ = between(3.7, 4.4);
    rear_ = between(3.7, 4.4);
    rise_ = between(2.75, 3.05);
    double west = 0;
    for (std::size_t b = 0; b < kBays; ++b) {
      const double width = b == stair_bay_ ? between(2.7, 3.1) : between(4.2, 5.0);
      const double centre = west + width / 2;
      bays_[b] = {west, west + width, b == stair_bay_ ? centre : centre + between(-0.8, 0.8)};
      west += width;
    }
  }

  // The two walls of the hallway with their doors, and those between the rooms. Outer walls need
  // not be there: nothing stands beyond them.
  std::vector<Wall> plan_walls(std::size_t storey) const {
    std::vector<Wall> walls;
    for (const double y : {-kHallway, kHallway}) {
      double from = bays_.front().west;
      for (std::size_t b = 0; b < kBays; ++b) {
        walls.push_back({true, y, from, bays_[b].door - kDoor});
        from = bays_[b].door + kDoor;
      }
      walls.push_back({true, y, from, bays_.back().east});
    }
    for (std::size_t b = 0; b + 1 < kBays; ++b) {
      const double x = bays_[b].east;
      walls.push_back({false, x, kHallway, kHallway + rear_});
      // On the ground floor two large rooms side by side at the front open into each other.
      const bool opens = storey == 0 && b != stair_bay_ && b + 1 != stair_bay_;
      const double middle = opening_y();
      walls.push_back({false, x, -kHallway - front_, opens ? middle - kOpening : -kHallway});
      if (opens) walls.push_back({false, x, middle + kOpening, -kHallway});
    }
    return walls;
  }
  double opening_y() const { return -kHallway - kFromDoor - 1.0; }

  std::size_t add(double x, double y, double floor, std::size_t storey, bool stairs = false) {
    const double dx = between(-kJitter, kJitter);
    const double dy = between(-kJitter, kJitter);
    stands_.push_back({{x + dx, y + dy, floor + kEyeHeight}, storey, stairs});
    building_.rooms.back().viewpoints.emplace_back(stands_.size() - 1);
    return stands_.size() - 1;
  }

  // A viewpoint at each bay's doors and one between two of them.
  std::size_t add_hallway(std::size_t storey) {
    building_.rooms.push_back({storey == 0 ? "hallway" : "upstairs hallway", {}});
    std::size_t beside_stairs = 0;
    for (std::size_t b = 0; b < kBays; ++b) {
      const double floor = rise_ * static_cast<double>(storey);
      const std::size_t v = add(bays_[b].door, 0, floor, storey);
      if (b == stair_bay_) beside_stairs = v;
      if (b + 1 < kBays) add((bays_[b].door + bays_[b + 1].door) / 2, 0, floor, storey);
    }
    return beside_stairs;
  }

  void add_rooms(std::size_t storey) {
    std::vector<std::string> names =
        storey == 0 ? std::vector<std::string>{"living room", "kitchen", "dining room", "study"}
                    : std::vector<std::string>{"main bedroom", "guest bedroom", "children's room",
                                               "library",      "sewing room",   "home office"};
    rng_.shuffle(std::span(names));
    for (std::size_t b = 0; b < kBays; ++b) {
      if (b == stair_bay_) {
        building_.rooms.push_back({storey == 0 ? "entryway" : "bathroom", {}});
        add_small_room(storey, bays_[b]);
        continue;
      }
      for (const double side : {-1.0, 1.0}) {
        building_.rooms.push_back({names.back(), {}});
        names.pop_back();
        add_large_room(storey, bays_[b], side);
      }
    }
  }

  void add_small_room(std::size_t storey, const Bay& bay) {
    const double floor = rise_ * static_cast<double>(storey);
    add(bay.door, -kHallway - kFromDoor, floor, storey);
    add(bay.door, -kHallway - kFromDoor - 1.9, floor, storey);
  }

  // One viewpoint inside the door, two at the back, often one more in the near corner.
  void add_large_room(std::size_t storey, const Bay& bay, double side) {
    const double floor = rise_ * static_cast<double>(storey);
    const double near = side * (kHallway + kFromDoor);
    const double far = near + side * ((side < 0 ? front_ : rear_) - kFromDoor - 0.9);
    const double centre = (bay.west + bay.east) / 2;
    add(bay.door, near, floor, storey);
    add(centre - 1.2, far, floor, storey);
    add(centre + 1.2, far, floor, storey);
    if (rng_.below(3) == 0) return;  // furniture
    const double away = bay.door < centre ? bay.east - bay.door : bay.west - bay.door;
    add(bay.door + (away > 0 ? away - 0.8 : away + 0.8), near, floor, storey);
  }

  // Whether a straight line stays `clear` of the walls of a storey.
  bool open(std::size_t storey, Vec3d a, Vec3d b, double clear) const {
    return std::ranges::none_of(walls_[storey], [&](const Wall& wall) {
      const double from = wall.along_x ? a.y : a.x, to = wall.along_x ? b.y : b.x;
      if ((from < wall.at) == (to < wall.at)) return false;
      const double t = (wall.at - from) / (to - from);
      const double crossing = wall.along_x ? a.x + t * (b.x - a.x) : a.y + t * (b.y - a.y);
      return crossing > wall.from - clear && crossing < wall.to + clear;
    });
  }

  void connect_by_sight() {
    edges_.resize(stands_.size());
    visible_.resize(stands_.size());
    for (std::size_t i = 0; i < stands_.size(); ++i) {
      for (std::size_t j = i + 1; j < stands_.size(); ++j) {
        const Stand &a = stands_[i], &b = stands_[j];
        if (a.storey != b.storey || !open(a.storey, a.point, b.point, 0)) continue;
        join(visible_, i, j);
        const bool walkable = open(a.storey, a.point, b.point, kBody);
        if (walkable && length(b.point - a.point) <= kLongestEdge) join(edges_, i, j);
      }
    }
  }

  // Up one flight to a landing at the back of the house, and back along the other flight.
  void add_stairs(const std::array<std::size_t, kStoreys>& foot) {
    building_.rooms.push_back({"stairs", {}});
    const double x = bays_[stair_bay_].door, landing = kHallway + rear_ - 0.9;
    const std::size_t lower = add(x - 0.6, kHallway + 1.4, 0.25 * rise_, 0, true);
    const std::size_t middle = add(x, landing, 0.5 * rise_, 0, true);
    const std::size_t upper = add(x + 0.6, kHallway + 1.4, 0.75 * rise_, 1, true);
    edges_.resize(stands_.size());
    visible_.resize(stands_.size());
    for (const auto& [a, b] :
         {std::pair(foot[0], lower), {lower, middle}, {middle, upper}, {upper, foot[1]}}) {
      join(edges_, a, b);
      join(visible_, a, b);
    }
  }

  using Adjacency = std::vector<std::vector<ViewpointIndex>>;
  static void join(Adjacency& adjacency, std::size_t i, std::size_t j) {
    adjacency[i].emplace_back(j);
    adjacency[j].emplace_back(i);
  }

  void finish() {
    Rng ids(seed_, stream_of("ids", 3));
    Rng headings(seed_, stream_of("headings", 8));
    for (std::size_t i = 0; i < stands_.size(); ++i) {
      std::ranges::sort(edges_[i]);
      std::ranges::sort(visible_[i]);
      scan::ConnectivityEntry entry;
      const std::uint64_t high = ids.next();
      entry.id = fmt::format("{:016x}{:016x}", high, ids.next());
      entry.pose = pose(stands_[i].point, degrees(static_cast<double>(headings.below(360))));
      entry.height = kEyeHeight;
      entry.unobstructed = std::move(edges_[i]);
      entry.visible = std::move(visible_[i]);
      building_.connectivity.entries.push_back(std::move(entry));
    }
  }

  // Matterport3D's camera to world: columns right, down, look; level, to the millimetre. Rounded,
  // so that the mathematics libraries of two platforms give the same digits.
  static std::array<double, 16> pose(Vec3d p, Radians heading) {
    const auto round_to = [](double value, double unit) { return std::round(value * unit) / unit; };
    const double s = round_to(std::sin(heading.value), 1e6) + 0.0;
    const double c = round_to(std::cos(heading.value), 1e6) + 0.0;
    return {c, 0,  s, round_to(p.x, 1e3), 0.0 - s, 0, c, round_to(p.y, 1e3),
            0, -1, 0, round_to(p.z, 1e3), 0,       0, 0, 1};
  }

  Rng rng_;
  std::uint64_t seed_;
  SmallBuilding building_;
  std::array<Bay, kBays> bays_{};
  std::size_t stair_bay_ = 0;
  double front_ = 0, rear_ = 0;  // depth of the rooms before and behind the hallway
  double rise_ = 0;              // from floor to floor
  std::array<std::vector<Wall>, kStoreys> walls_;
  std::vector<Stand> stands_;
  Adjacency edges_, visible_;
};

}  // namespace

SmallBuilding make_small_building(std::uint64_t seed, const std::string& scan) {
  return Builder(seed, scan).run();
}

}  // namespace enfilade::homes
