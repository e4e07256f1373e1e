#include "enfilade/homes/furniture/furnish_room.h"

#include <array>
#include <cmath>
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

double Frame::angle() const { return quarters % 4 * (std::numbers::pi / 2); }

Vec3d Frame::to_world(double x, double y, double z) const {
  constexpr std::array<std::array<double, 2>, 4> kCosSin{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const auto [c, s] = kCosSin[quarters % 4];
  return {origin.x + c * x - s * y, origin.y + s * x + c * y, origin.z + z};
}

FurnishedRoom::FurnishedRoom(const looks::RoomSpace& space, const looks::RoomStyle& style, Rng& rng,
                             looks::HomeParts& parts)
    : space_(space), style_(style), rng_(rng), parts_(parts), clear_(space.keep_clear) {
  for (const auto& hole : space.holes) {
    if (!hole.is_door()) continue;
    const Frame frame = wall_frame(hole.wall, hole.middle());
    const double half = (hole.to - hole.from) / 2 + 0.05;
    clear_.push_back(around(frame.to_world(-half, 0), frame.to_world(half, kBeforeDoors)));
  }
}

std::pair<double, double> FurnishedRoom::wall_ends(Side wall) const {
  return space_.floor.range(runs_along_x(wall));
}

Frame FurnishedRoom::wall_frame(Side wall, double along) const {
  const double n = space_.floor.at(wall), z = space_.floor_z;
  const Vec3d origin = runs_along_x(wall) ? Vec3d{along, n, z} : Vec3d{n, along, z};
  return {origin, static_cast<unsigned>(index(wall) + 1) % 4};
}

Frame FurnishedRoom::middle() const {
  const Rect& f = space_.floor;
  return {{(f.x0 + f.x1) / 2, (f.y0 + f.y1) / 2, space_.floor_z}, 0};
}

const Shape& FurnishedRoom::pick(std::string_view noun) {
  const auto shapes = shapes_of(noun);
  return *shapes[rng_.below(shapes.size())];
}

Rect FurnishedRoom::footprint(const Item& item, const Frame& frame) const {
  const double c = std::abs(std::cos(item.turned)), s = std::abs(std::sin(item.turned));
  const double hx = (c * item.size.w + s * item.size.d) / 2;
  const double hy = (s * item.size.w + c * item.size.d) / 2;
  return around(frame.to_world(item.x - hx, item.y - hy), frame.to_world(item.x + hx, item.y + hy));
}

FurnishedRoom::Solid FurnishedRoom::solid(const Item& item, const Frame& frame) const {
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

void FurnishedRoom::put(const Item& item, const Frame& frame) {
  built_.push_back(solid(item, frame));
  const mesh::Placement at{frame.to_world(item.x, item.y, item.z), frame.angle() + item.turned};
  build_shape(*item.shape, item.size, at, space_.room, style_, rng_, parts_, item.power);
}

bool FurnishedRoom::put_if_clear(const Item& item, const Frame& frame) {
  if (meets_any(solid(item, frame), built_)) return false;
  put(item, frame);
  return true;
}

bool FurnishedRoom::commit(const Group& group, const Frame& frame, std::optional<Side> wall) {
  std::vector<Rect> rects;
  for (const Item& item : group.items) {
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
  for (const Item& item : group.items) {
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

bool FurnishedRoom::place(const Group& group, const Frame& frame) {
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

Spot FurnishedRoom::describe(const Frame& frame, Side wall, double along, double w) const {
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

std::vector<Spot> FurnishedRoom::spots(const Group& group) const {
  constexpr double kStep = 0.1;
  std::vector<Spot> found;
  double tallest = 0;
  for (const Item& item : group.items) {
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
      const Frame frame = wall_frame(wall, along);
      const Rect whole =
          around(frame.to_world(-group.w / 2, 0.005), frame.to_world(group.w / 2, group.d));
      if (!fits({whole})) continue;
      found.push_back(describe(frame, wall, along, group.w));
    }
  }
  return found;
}

std::optional<Spot> FurnishedRoom::place_at_wall(const Group& group, const Score& score) {
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

std::optional<Spot> FurnishedRoom::place_at_wall(const Shape& shape, const Score& score,
                                                 double front) {
  const auto [w, d, h] = shape.size;
  return place_at_wall({w, d + 0.02, front, {{shape, 0, d / 2 + 0.015}}}, score);
}

std::optional<Frame> FurnishedRoom::place_free(const Group& group, Vec3d towards) {
  constexpr double kStep = 0.2;
  constexpr std::size_t kTries = 16;
  struct Scored {
    double value;
    Frame frame;
  };
  std::vector<Scored> all;
  const Rect& f = space_.floor;
  const auto first = static_cast<unsigned>(rng_.below(4));
  for (unsigned turn = 0; turn < 4; ++turn) {
    const unsigned q = (first + turn) % 4;
    for (double cx = f.x0 + 0.3; cx < f.x1 - 0.3; cx += kStep) {
      for (double cy = f.y0 + 0.3; cy < f.y1 - 0.3; cy += kStep) {
        Frame frame{{cx, cy, space_.floor_z}, q};
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

bool FurnishedRoom::hang(const Shape& shape, Size size, Side wall, double along, double low,
                         double slide, double apart) {
  if (low + size.h > height() - 0.08) return false;
  const auto [from, to] = wall_ends(wall);
  for (double off = 0; off <= slide + 1e-9; off += 0.15) {
    for (const double side : {-1.0, 1.0}) {
      const double at = along + side * off;
      const WallItem item{wall, at - size.w / 2, at + size.w / 2, low, low + size.h};
      if (item.from < from + 0.05 || item.to > to - 0.05 || !wall_is_free(item, apart)) continue;
      const Frame frame = wall_frame(wall, at);
      const Item hung{shape, size, 0, size.d / 2 + 0.002, low};
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

bool FurnishedRoom::hang_anywhere(const Shape& shape, double low) {
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

bool FurnishedRoom::lay(const Shape& shape, Size size, const Frame& frame, double x, double y) {
  const Rect r = footprint({shape, size, x, y}, frame);
  const Rect& f = space_.floor;
  const Rect in{std::max(r.x0, f.x0 + 0.06), std::max(r.y0, f.y0 + 0.06),
                std::min(r.x1, f.x1 - 0.06), std::min(r.y1, f.y1 - 0.06)};
  if (in.width() < 0.35 || in.depth() < 0.35 || overlaps_any(in, rugs_)) return false;
  const bool across = frame.quarters % 2 == 1;
  const Size cut{across ? in.depth() : in.width(), across ? in.width() : in.depth(), size.h};
  const Vec3d middle{(in.x0 + in.x1) / 2, (in.y0 + in.y1) / 2, space_.floor_z};
  // A little above the floor, so that the two surfaces do not lie in one plane.
  put({shape, cut, 0, 0, 0.002}, {middle, frame.quarters});
  rugs_.push_back(in);
  return true;
}

}  // namespace enfilade::homes::furniture
