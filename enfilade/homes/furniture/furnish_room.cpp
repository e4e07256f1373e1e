#include "enfilade/homes/furniture/furnish_room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace enfilade::homes::furniture {
namespace {

constexpr double kFlat = 0.07;         // lower things lie on the floor; people walk over them
constexpr double kBeforeDoors = 0.85;  // metres

bool overlap(const Rect& a, const Rect& b) {
  constexpr double kTouch = 0.005;
  return a.x0 < b.x1 - kTouch && b.x0 < a.x1 - kTouch && a.y0 < b.y1 - kTouch &&
         b.y0 < a.y1 - kTouch;
}
bool overlaps_any(const Rect& a, const std::vector<Rect>& all) {
  return std::any_of(all.begin(), all.end(), [&](const Rect& b) { return overlap(a, b); });
}
bool holds(const Rect& outer, const Rect& inner) {
  constexpr double kTouch = 0.005;
  return inner.x0 > outer.x0 - kTouch && inner.x1 < outer.x1 + kTouch &&
         inner.y0 > outer.y0 - kTouch && inner.y1 < outer.y1 + kTouch;
}

Rect around(Vec3d a, Vec3d b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::max(a.x, b.x), std::max(a.y, b.y)};
}

}  // namespace

double GroupFrame::angle() const { return quarters % 4 * (std::numbers::pi / 2); }

Vec3d GroupFrame::to_world(double x, double y, double z) const {
  constexpr std::array<std::array<double, 2>, 4> kCosSin{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const auto [c, s] = kCosSin[quarters % 4];
  return {origin.x + c * x - s * y, origin.y + s * x + c * y, origin.z + z};
}

FurnishedRoom::FurnishedRoom(const looks::RoomSpace& space, const looks::RoomStyle& style, Rng& rng,
                             looks::HomeParts& parts)
    : space_(space), style_(style), rng_(rng), parts_(parts), clear_(space.keep_clear) {
  for (const auto& hole : space.holes) {
    if (!hole.is_door()) continue;
    const GroupFrame frame = wall_frame(hole.wall, hole.middle());
    const double half = (hole.to - hole.from) / 2 + 0.05;
    clear_.push_back(around(frame.to_world(-half, 0), frame.to_world(half, kBeforeDoors)));
  }
}

std::pair<double, double> FurnishedRoom::wall_ends(Side wall) const {
  return space_.floor.range(runs_along_x(wall));
}

GroupFrame FurnishedRoom::wall_frame(Side wall, double along) const {
  const double n = space_.floor.at(wall), z = space_.floor_z;
  const Vec3d origin = runs_along_x(wall) ? Vec3d{along, n, z} : Vec3d{n, along, z};
  return {origin, static_cast<unsigned>(index(wall) + 1) % 4};
}

GroupFrame FurnishedRoom::middle() const {
  const Rect& f = space_.floor;
  return {{(f.x0 + f.x1) / 2, (f.y0 + f.y1) / 2, space_.floor_z}, 0};
}

const FurnitureShape& FurnishedRoom::pick(std::string_view noun) {
  const auto shapes = shapes_of(noun);
  return *shapes[rng_.below(shapes.size())];
}

Rect FurnishedRoom::footprint(const GroupItem& item, const GroupFrame& frame) const {
  const double c = std::abs(std::cos(item.turned)), s = std::abs(std::sin(item.turned));
  const double hx = (c * item.size.w + s * item.size.d) / 2;
  const double hy = (s * item.size.w + c * item.size.d) / 2;
  return around(frame.to_world(item.x - hx, item.y - hy), frame.to_world(item.x + hx, item.y + hy));
}

FurnishedRoom::Solid FurnishedRoom::solid(const GroupItem& item, const GroupFrame& frame) const {
  return {footprint(item, frame), item.z, item.z + item.size.h};
}

bool FurnishedRoom::meets_any(const Solid& solid, const std::vector<Solid>& others) {
  constexpr double kTouch = 0.005;
  return std::any_of(others.begin(), others.end(), [&](const Solid& other) {
    return solid.low < other.high - kTouch && other.low < solid.high - kTouch &&
           overlap(solid.box, other.box);
  });
}

bool FurnishedRoom::fits(const std::vector<Rect>& rects) const {
  return std::all_of(rects.begin(), rects.end(), [&](const Rect& r) {
    return holds(space_.floor, r) && !overlaps_any(r, standing_) && !overlaps_any(r, clear_) &&
           !overlaps_any(r, used_);
  });
}

void FurnishedRoom::put(const GroupItem& item, const GroupFrame& frame) {
  built_.push_back(solid(item, frame));
  const mesh::Placement at{frame.to_world(item.x, item.y, item.z), frame.angle() + item.turned};
  build_shape(*item.shape, item.size, at, space_.room, style_, rng_, parts_, item.power);
}

bool FurnishedRoom::put_if_clear(const GroupItem& item, const GroupFrame& frame) {
  if (meets_any(solid(item, frame), built_)) return false;
  put(item, frame);
  return true;
}

bool FurnishedRoom::commit(const FurnitureGroup& group, const GroupFrame& frame,
                           std::optional<Side> wall) {
  std::vector<Rect> rects;
  for (const GroupItem& item : group.items) {
    if (item.z < 1.9 && item.size.h > kFlat && item.z < kFlat) {
      rects.push_back(footprint(item, frame));
    }
    if (meets_any(solid(item, frame), hung_)) return false;
  }
  const Rect front = around(frame.to_world(-group.w / 2, group.d),
                            frame.to_world(group.w / 2, group.d + group.front));
  if (!fits(rects) || (group.front > 0 && overlaps_any(front, standing_))) return false;
  const std::size_t before = standing_.size();
  standing_.insert(standing_.end(), rects.begin(), rects.end());
  if (!ways_are_open(space_, standing_)) {
    standing_.resize(before);
    return false;
  }
  if (group.front > 0) used_.push_back(front);
  for (const GroupItem& item : group.items) {
    put(item, frame);
    if (!wall) continue;
    const Rect r = footprint(item, frame);
    const auto [from, to] = r.range(runs_along_x(*wall));
    if (item.y - item.size.d / 2 < 0.3) {
      on_walls_.push_back({*wall, from, to, item.z, item.z + item.size.h});
    }
  }
  return true;
}

bool FurnishedRoom::place(const FurnitureGroup& group, const GroupFrame& frame) {
  return commit(group, frame, std::nullopt);
}

bool FurnishedRoom::wall_is_free(const WallItem& item, double margin) const {
  const auto meets = [&](Side wall, double from, double to, double low, double high) {
    return wall == item.wall && from < item.to + margin && to > item.from - margin &&
           low < item.high + margin && high > item.low - margin;
  };
  for (const auto& hole : space_.holes) {
    if (meets(hole.wall, hole.from, hole.to, hole.sill, hole.head)) return false;
  }
  return std::none_of(on_walls_.begin(), on_walls_.end(), [&](const WallItem& other) {
    return meets(other.wall, other.from, other.to, other.low, other.high);
  });
}

Spot FurnishedRoom::describe(const GroupFrame& frame, Side wall, double along, double w) const {
  const auto [from, to] = wall_ends(wall);
  Spot spot{frame, wall, along, 0, 0, 9, false};
  spot.off_centre = std::abs(along - (from + to) / 2) / std::max(0.01, (to - from) / 2);
  spot.corner = std::min(along - w / 2 - from, to - along - w / 2);
  for (const auto& hole : space_.holes) {
    if (hole.is_door()) {
      const Vec3d d = wall_frame(hole.wall, hole.middle()).origin - frame.origin;
      spot.door = std::min(spot.door, length(d));
    } else if (hole.wall == wall) {
      const double reach = (w + hole.to - hole.from) / 2;
      if (std::abs(hole.middle() - along) < reach) spot.window = true;
    }
  }
  return spot;
}

std::vector<Spot> FurnishedRoom::spots(const FurnitureGroup& group) const {
  constexpr double kStep = 0.1;
  std::vector<Spot> found;
  double tallest = 0;
  for (const GroupItem& item : group.items) {
    if (item.y - item.size.d / 2 < 0.3) tallest = std::max(tallest, item.z + item.size.h);
  }
  for (const Side wall : kSides) {
    const auto [from, to] = wall_ends(wall);
    const double first = from + group.w / 2 + 0.01, last = to - group.w / 2 - 0.01;
    if (last < first) continue;
    const auto n = static_cast<unsigned>((last - first) / kStep) + 1;
    for (unsigned i = 0; i <= n; ++i) {
      const double along = i == n ? last : first + i * kStep;
      if (!wall_is_free({wall, along - group.w / 2, along + group.w / 2, 0, tallest}, 0.0))
        continue;
      const GroupFrame frame = wall_frame(wall, along);
      const Rect whole =
          around(frame.to_world(-group.w / 2, 0.005), frame.to_world(group.w / 2, group.d));
      if (!fits({whole})) continue;
      found.push_back(describe(frame, wall, along, group.w));
    }
  }
  return found;
}

std::optional<Spot> FurnishedRoom::place_at_wall(const FurnitureGroup& group, const Score& score) {
  constexpr std::size_t kTries = 10;
  struct Scored {
    double value;
    Spot spot;
  };
  std::vector<Scored> all;
  for (const Spot& spot : spots(group)) {
    all.push_back({score(spot) + 0.35 * rng_.uniform(), spot});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Scored& a, const Scored& b) { return a.value > b.value; });
  // Places next to one that failed mostly fail too, so only places that lie apart are tried.
  std::vector<Spot> tried;
  for (const Scored& s : all) {
    const bool apart = std::all_of(tried.begin(), tried.end(), [&](const Spot& t) {
      return t.wall != s.spot.wall || std::abs(t.along - s.spot.along) > 0.25;
    });
    if (!apart) continue;
    if (commit(group, s.spot.frame, s.spot.wall)) return s.spot;
    tried.push_back(s.spot);
    if (tried.size() == kTries) break;
  }
  return std::nullopt;
}

std::optional<Spot> FurnishedRoom::place_at_wall(const FurnitureShape& shape, const Score& score,
                                                 double front) {
  const auto [w, d, h] = shape.size;
  return place_at_wall({w, d + 0.02, front, {{shape, 0, d / 2 + 0.015}}}, score);
}

std::optional<GroupFrame> FurnishedRoom::place_free(const FurnitureGroup& group, Vec3d towards) {
  constexpr double kStep = 0.2;
  constexpr std::size_t kTries = 16;
  struct Scored {
    double value;
    GroupFrame frame;
  };
  std::vector<Scored> all;
  const Rect& f = space_.floor;
  const auto first = static_cast<unsigned>(rng_.below(4));
  for (unsigned turn = 0; turn < 4; ++turn) {
    const unsigned q = (first + turn) % 4;
    for (double cx = f.x0 + 0.3; cx < f.x1 - 0.3; cx += kStep) {
      for (double cy = f.y0 + 0.3; cy < f.y1 - 0.3; cy += kStep) {
        GroupFrame frame{{cx, cy, space_.floor_z}, q};
        frame.origin = frame.to_world(0, -group.d / 2);
        const Rect whole =
            around(frame.to_world(-group.w / 2, 0), frame.to_world(group.w / 2, group.d));
        if (!fits({whole})) continue;
        const double dx = cx - towards.x, dy = cy - towards.y;
        const double away = std::sqrt(dx * dx + dy * dy);
        all.push_back({away + 0.1 * turn + 0.2 * rng_.uniform(), frame});
      }
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Scored& a, const Scored& b) { return a.value < b.value; });
  for (std::size_t i = 0; i < std::min(kTries * 3, all.size()); i += 3) {
    if (commit(group, all[i].frame, std::nullopt)) return all[i].frame;
  }
  return std::nullopt;
}

bool FurnishedRoom::hang(const FurnitureShape& shape, FurnitureSize size, Side wall, double along,
                         double low, double slide, double apart) {
  if (low + size.h > height() - 0.08) return false;
  const auto [from, to] = wall_ends(wall);
  for (double off = 0; off <= slide + 1e-9; off += 0.15) {
    for (const double side : {-1.0, 1.0}) {
      const double at = along + side * off;
      const WallItem item{wall, at - size.w / 2, at + size.w / 2, low, low + size.h};
      if (item.from < from + 0.05 || item.to > to - 0.05 || !wall_is_free(item, apart)) continue;
      const GroupFrame frame = wall_frame(wall, at);
      const GroupItem hung{shape, size, 0, size.d / 2 + 0.002, low};
      if (meets_any(solid(hung, frame), built_)) continue;
      const Rect below =
          around(frame.to_world(-size.w / 2, 0.01), frame.to_world(size.w / 2, size.d));
      if (size.d > kFlat && overlaps_any(below, clear_)) continue;
      on_walls_.push_back(item);
      hung_.push_back(solid(hung, frame));
      put(hung, frame);
      return true;
    }
  }
  return false;
}

bool FurnishedRoom::hang_anywhere(const FurnitureShape& shape, double low) {
  constexpr double kApart = 0.25;  // nearer frames seem to overlap when seen along the wall
  const auto first = rng_.below(4);
  for (std::size_t i = 0; i < 4; ++i) {
    const Side wall = kSides[(first + i) % 4];
    const auto [from, to] = wall_ends(wall);
    const double at = from + (to - from) * between(0.25, 0.75);
    if (hang(shape, shape.size, wall, at, low, (to - from) / 2, kApart)) return true;
  }
  return false;
}

bool FurnishedRoom::lay(const FurnitureShape& shape, FurnitureSize size, const GroupFrame& frame,
                        double x, double y) {
  const Rect r = footprint({shape, size, x, y}, frame);
  const Rect& f = space_.floor;
  const Rect in{std::max(r.x0, f.x0 + 0.06), std::max(r.y0, f.y0 + 0.06),
                std::min(r.x1, f.x1 - 0.06), std::min(r.y1, f.y1 - 0.06)};
  if (in.width() < 0.35 || in.depth() < 0.35 || overlaps_any(in, rugs_)) return false;
  const bool across = frame.quarters % 2 == 1;
  const FurnitureSize cut{across ? in.depth() : in.width(), across ? in.width() : in.depth(),
                          size.h};
  const Vec3d middle{(in.x0 + in.x1) / 2, (in.y0 + in.y1) / 2, space_.floor_z};
  // A little above the floor, so that the two surfaces do not lie in one plane.
  put({shape, cut, 0, 0, 0.002}, {middle, frame.quarters});
  rugs_.push_back(in);
  return true;
}

namespace {

constexpr double kCell = 0.08;

/// The floor as a grid of cells: those where the middle of a body with some radius can be.
class FloorGrid {
 public:
  FloorGrid(const Rect& floor, double radius)
      : floor_(floor),
        radius_(radius),
        nx_(std::max<std::size_t>(1, static_cast<std::size_t>(floor.width() / kCell))),
        ny_(std::max<std::size_t>(1, static_cast<std::size_t>(floor.depth() / kCell))),
        free_(nx_ * ny_, 1) {
    for (std::size_t i = 0; i < free_.size(); ++i) {
      const double x = x_of(i), y = y_of(i);
      const double edge = std::min({x - floor.x0, floor.x1 - x, y - floor.y0, floor.y1 - y});
      if (edge < radius_) free_[i] = 0;
    }
  }

  void block(const Rect& r) {
    const auto from = [](double v) { return static_cast<std::size_t>(std::max(0.0, v)); };
    const std::size_t i0 = from((r.x0 - radius_ - floor_.x0) / kCell - 1);
    const std::size_t i1 = std::min(nx_, from((r.x1 + radius_ - floor_.x0) / kCell + 1));
    const std::size_t k0 = from((r.y0 - radius_ - floor_.y0) / kCell - 1);
    const std::size_t k1 = std::min(ny_, from((r.y1 + radius_ - floor_.y0) / kCell + 1));
    for (std::size_t k = k0; k < k1; ++k) {
      for (std::size_t i = i0; i < i1; ++i) {
        const std::size_t cell = k * nx_ + i;
        const double dx = std::max({r.x0 - x_of(cell), x_of(cell) - r.x1, 0.0});
        const double dy = std::max({r.y0 - y_of(cell), y_of(cell) - r.y1, 0.0});
        if (dx * dx + dy * dy < radius_ * radius_) free_[cell] = 0;
      }
    }
  }

  /// The free cell nearest to a point, at most `reach` away.
  std::optional<std::size_t> nearest(double x, double y, double reach) const {
    std::optional<std::size_t> best;
    double nearest = reach * reach;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (free_[i] == 0) continue;
      const double dx = x_of(i) - x, dy = y_of(i) - y;
      if (dx * dx + dy * dy > nearest) continue;
      nearest = dx * dx + dy * dy;
      best = i;
    }
    return best;
  }

  std::vector<std::uint8_t> reached_from(std::size_t start) const {
    std::vector<std::uint8_t> seen(free_.size(), 0);
    std::vector<std::size_t> open{start};
    seen[start] = 1;
    while (!open.empty()) {
      const std::size_t cell = open.back();
      open.pop_back();
      const std::size_t i = cell % nx_, k = cell / nx_;
      const auto visit = [&](std::size_t next) {
        if (free_[next] == 0 || seen[next] != 0) return;
        seen[next] = 1;
        open.push_back(next);
      };
      if (i > 0) visit(cell - 1);
      if (i + 1 < nx_) visit(cell + 1);
      if (k > 0) visit(cell - nx_);
      if (k + 1 < ny_) visit(cell + nx_);
    }
    return seen;
  }

  double distance(std::size_t cell, double x, double y) const {
    const double dx = x_of(cell) - x, dy = y_of(cell) - y;
    return std::sqrt(dx * dx + dy * dy);
  }
  const std::vector<std::uint8_t>& free() const { return free_; }

 private:
  double x_of(std::size_t cell) const {
    return floor_.x0 + (double(cell % nx_) + 0.5) * floor_.width() / double(nx_);
  }
  double y_of(std::size_t cell) const {
    return floor_.y0 + (double(cell / nx_) + 0.5) * floor_.depth() / double(ny_);
  }

  Rect floor_;
  double radius_;
  std::size_t nx_, ny_;
  std::vector<std::uint8_t> free_;
};

/// The free cell nearest to the point `deep` metres inside a door, at most `reach` from it.
std::optional<std::size_t> cell_inside(const looks::RoomSpace& space, const FloorGrid& grid,
                                       const looks::RoomSpace::WallHole& door, double deep,
                                       double reach) {
  const double n = space.floor.at(door.wall) + (is_high(door.wall) ? -deep : deep);
  return runs_along_x(door.wall) ? grid.nearest(door.middle(), n, reach)
                                 : grid.nearest(n, door.middle(), reach);
}

bool connected(const looks::RoomSpace& space, const FloorGrid& grid, double radius) {
  const Rect& f = space.floor;
  const double mx = (f.x0 + f.x1) / 2, my = (f.y0 + f.y1) / 2;
  std::optional<std::size_t> first;
  std::vector<std::uint8_t> reached;
  for (const auto& hole : space.holes) {
    if (!hole.is_door()) continue;
    const auto cell = cell_inside(space, grid, hole, radius + kCell, 2.5 * kCell);
    if (!cell) return false;
    if (!first) {
      first = cell;
      reached = grid.reached_from(*cell);
    } else if (reached[*cell] == 0) {
      return false;
    }
  }
  if (!first) return true;
  // A table may stand in the middle itself: a place beside it is enough.
  const double near = std::max(0.9, 0.55 * std::min(f.width(), f.depth()));
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (reached[i] != 0 && grid.distance(i, mx, my) <= near) return true;
  }
  return false;
}

/// The area of free floor, m2, that cannot be reached from the first door.
double cut_off(const looks::RoomSpace& space, const FloorGrid& grid, double radius) {
  for (const auto& hole : space.holes) {
    if (!hole.is_door()) continue;
    const auto cell = cell_inside(space, grid, hole, radius + kCell, 3 * kCell);
    if (!cell) continue;
    const auto reached = grid.reached_from(*cell);
    std::size_t lost = 0;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      if (grid.free()[i] != 0 && reached[i] == 0) ++lost;
    }
    return double(lost) * kCell * kCell;
  }
  return 0;
}

}  // namespace

bool ways_are_open(const looks::RoomSpace& space, const std::vector<Rect>& standing) {
  constexpr double kHalfWay = 0.375, kBody = 0.25, kLeastPocket = 0.5;
  const double half = std::min(space.floor.width(), space.floor.depth()) / 2;
  const double way = std::min(kHalfWay, half - 0.8 * kCell), body = std::min(kBody, way);
  if (way <= 0) return standing.empty();
  FloorGrid wide(space.floor, way), narrow(space.floor, body);
  for (const auto* blocked : {&standing, &space.no_way}) {
    for (const Rect& r : *blocked) {
      wide.block(r);
      narrow.block(r);
    }
  }
  return connected(space, wide, way) && cut_off(space, narrow, body) <= kLeastPocket;
}

}  // namespace enfilade::homes::furniture
