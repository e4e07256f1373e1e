#include "enfilade/homes/plan/draws.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>

namespace enfilade::homes::plan {
namespace {

constexpr double kNib = 0.16;      // metres of wall between a corner and a door
constexpr double kBetween = 0.35;  // metres of wall between two openings
constexpr double kHighestHead = 2.4;
constexpr std::string_view kSocial = "ldkfn";

using Interval = std::pair<double, double>;

void take_out(std::vector<Interval>& free, double from, double to) {
  std::vector<Interval> rest;
  for (const auto& [a, b] : free) {
    if (from > a) rest.emplace_back(a, std::min(b, from));
    if (to < b) rest.emplace_back(std::max(a, to), b);
  }
  std::erase_if(rest, [](const Interval& i) { return i.second - i.first < 1e-9; });
  free = std::move(rest);
}

constexpr double kNever = 1e9;

// How wide a door of a room is.
double door_width(char type, Rng& rng) {
  if (is_one_of(type, "tc")) return 0.9;
  if (is_one_of(type, "nmdlkgC")) return snap(draw(rng, 0.95, 1.1));
  return snap(draw(rng, 0.9, 1.0));
}

// The outer wall of a room on a side of the outline, as an opening without width.
std::optional<Opening> outer_wall(const Sketch& sketch, std::size_t room, Side side) {
  const Rect &box = sketch.cells[room].box, &m = sketch.middle;
  if (std::abs(box.at(side) - m.at(side)) > 1e-6) return std::nullopt;
  Opening o;
  o.room0 = room;
  o.along_x = runs_along_x(side);
  o.wall = m.at(side);
  return o;
}

/// How windows of a room type are.
struct WindowKind {
  double share = 1, low = 1.0, high = 1.6;  // chance of one in a further wall; width, metres
  double sill = 0.85, head = 2.15, spacing = 1.0;
};
WindowKind window_kind(char type, bool tall) {
  if (is_one_of(type, "py")) return {1, 1.6, 4.0, 0.95, 2.35, 0.4};
  if (is_one_of(type, "atS")) return {0.6, 0.55, 0.8, 1.35, 2.0, 2.0};
  if (is_one_of(type, "cjuz")) return {0.3, 0.5, 0.8, 1.3, 1.95, 2.0};
  if (type == 'g') return {0.5, 0.8, 1.2, 1.3, 1.95, 2.0};
  if (type == 'k') return {0.8, 1.0, 1.6, 1.05, 2.15, 1.2};
  if (is_one_of(type, "hse")) return {0.9, 0.8, 1.4, 0.9, 2.1, 1.6};
  if (is_one_of(type, "lfnd")) return {0.8, 1.4, 2.3, tall ? 0.45 : 0.75, 2.25, 1.0};
  return {0.7, 1.1, 1.8, tall ? 0.5 : 0.85, 2.15, 1.1};
}

/// One storey's openings in the making.
class Openings {
 public:
  Openings(const Sketch& sketch, Plan& plan, unsigned storey, Rng& rng)
      : sketch_(sketch), plan_(plan), storey_(storey), rng_(rng) {
    tall_windows_ = chance(rng, 0.4);
    door_head_ = snap(draw(rng, 2.0, 2.15));
  }

  bool add() {
    if (!add_entrances()) return false;
    add_corridor_arches();
    if (!add_room_doors()) return false;
    add_enfilades();
    for (std::size_t r = 0; r < sketch_.cells.size(); ++r) {
      if (here(r)) add_windows(r);
    }
    return true;
  }

 private:
  bool here(std::size_t room) const { return plan_.rooms[room].storey == storey_; }

  bool joined(std::size_t a, std::size_t b) const {
    return std::ranges::any_of(plan_.openings, [&](const Opening& o) {
      return (o.room0 == a && o.room1 == b) || (o.room0 == b && o.room1 == a);
    });
  }

  // Where a wall has no opening yet and no flight runs along it.
  std::vector<Interval> free_wall(const Opening& o, double lo, double hi, double nib) const {
    std::vector<Interval> free{{lo + nib, hi - nib}};
    if (hi - lo <= 2 * nib) return {};
    if (sketch_.flight) {
      const Rect& f = sketch_.flight->box;
      const Rect zone = both_sides(o.along_x, o.wall, lo, hi, kStand);
      const auto [from, to] = f.range(o.along_x);
      if (overlap(zone, f)) take_out(free, from - 0.1, to + 0.1);
    }
    for (const Opening& p : plan_.openings) {
      if (!here(p.room0) || p.along_x != o.along_x || std::abs(p.wall - o.wall) > 1e-6) continue;
      take_out(free, p.from - kBetween, p.to + kBetween);
    }
    return free;
  }

  // Would a door's zone meet a leaf that stands open, or a leaf another's zone or leaf?
  bool clashes(const Rect& zone, bool leaf) const {
    for (const Opening& p : plan_.openings) {
      if (!here(p.room0) || p.kind == OpeningKind::kWindow) continue;
      const auto other = leaf_zone(plan_, p);
      if (other && overlap(*other, zone)) return true;
      if (leaf && overlap(opening_zone(plan_, p), zone)) return true;
    }
    return false;
  }

  // Of the leaf that `o` says: low where it lies against a wall.
  double leaf_cost(const Opening& o) const {
    const std::size_t room = o.leaf_in_room1 ? *o.room1 : o.room0;
    const Rect& floor = plan_.rooms[room].floor;
    const Rect leaf = *leaf_zone(plan_, o);
    // A hotel room's small hall has space for the leaf of its own door only.
    const bool small_hall = sketch_.cells[room].type == 'e' && !sketch_.cells[room].spine;
    const bool own = sketch_.cells[o.room0].spine || sketch_.cells[*o.room1].spine;
    if (small_hall && !own) return kNever;
    const double deep = floor.length(!o.along_x);
    if (deep < o.to - o.from + 0.15) return kNever;
    if (leaf.x0 < floor.x0 || leaf.x1 > floor.x1 || leaf.y0 < floor.y0 || leaf.y1 > floor.y1) {
      return kNever;
    }
    if (sketch_.flight && overlap(leaf, sketch_.flight->box)) return kNever;
    if (clashes(leaf, true)) return kNever;
    const auto [low, high] = floor.range(o.along_x);
    const double corner = o.hinge_at_to ? high - o.to : o.from - low;
    return std::min(corner, 1.6) + (sketch_.cells[room].spine ? 2.5 : 0);
  }

  // Chooses the best leaf for a door; its cost, kNever if the door cannot be here.
  double door_cost(Opening& o) const {
    const Rect zone = opening_zone(plan_, o);
    if (!clear_of_flight(zone, sketch_.flight) || clashes(zone, false)) return kNever;
    double best = 3;  // without a leaf
    const double angle = o.leaf;
    o.leaf = 0;
    Opening chosen = o;
    for (const bool in_room1 : {false, true}) {
      for (const bool at_to : {false, true}) {
        Opening with = o;
        with.leaf = angle;
        with.leaf_in_room1 = in_room1;
        with.hinge_at_to = at_to;
        const double cost = leaf_cost(with);
        if (cost >= best) continue;
        best = cost;
        chosen = with;
      }
    }
    o = chosen;
    return best;
  }

  bool place_door(const Opening& wanted, const std::vector<Interval>& free, double width) {
    double best = kNever;
    Opening chosen;
    const double angle = draw(rng_, 85, 93);
    for (const auto& [a, b] : free) {
      if (b - a < width) continue;
      const int tries = std::max(1, static_cast<int>((b - a - width) / 0.25));
      for (int i = 0; i <= tries; ++i) {
        Opening o = wanted;
        o.from = a + (b - a - width) * i / tries;
        o.to = o.from + width;
        o.leaf = angle;
        const double cost = door_cost(o) + 0.2 * rng_.uniform();
        if (cost < best) {
          best = cost;
          chosen = o;
        }
      }
    }
    if (best >= kNever) return false;
    plan_.openings.push_back(chosen);
    return true;
  }

  bool place_arch(Opening o, std::vector<Interval> free, double least, double most) {
    std::ranges::sort(free, std::greater(), [](const Interval& i) { return i.second - i.first; });
    for (const auto& [a, b] : free) {
      for (const double width : {std::min(most, b - a), least}) {
        if (width < least || width > b - a) continue;
        for (const double at : {0.5, 0.0, 1.0, 0.25, 0.75}) {
          o.from = a + (b - a - width) * at;
          o.to = o.from + width;
          const Rect zone = opening_zone(plan_, o);
          if (!clear_of_flight(zone, sketch_.flight) || clashes(zone, false)) continue;
          plan_.openings.push_back(o);
          return true;
        }
      }
    }
    return false;
  }

  // A door `most` metres wide, or an arch between `least` and `most`.
  bool join(std::size_t a, std::size_t b, OpeningKind kind, double least, double most) {
    const auto wall = shared_wall(sketch_.cells[a].box, sketch_.cells[b].box);
    if (!wall) return false;
    Opening o;
    o.kind = kind;
    o.room0 = wall->first_is_lower ? a : b;
    o.room1 = wall->first_is_lower ? b : a;
    o.along_x = wall->along_x;
    o.wall = wall->wall;
    const auto [low0, high0] = plan_.rooms[a].floor.range(o.along_x);
    const auto [low1, high1] = plan_.rooms[b].floor.range(o.along_x);
    const double lo = std::max(low0, low1), hi = std::min(high0, high1);
    const bool arch = kind == OpeningKind::kArch;
    const double ceiling = std::min(plan_.rooms[a].ceiling, plan_.rooms[b].ceiling);
    o.head = arch ? std::min(kHighestHead, ceiling - 0.15) : door_head_;
    const auto free = free_wall(o, lo, hi, kNib);
    return arch ? place_arch(o, free, least, most) : place_door(o, free, most);
  }

  void add_corridor_arches() {
    for (std::size_t a = 0; a < sketch_.cells.size(); ++a) {
      if (!here(a) || !sketch_.cells[a].spine) continue;
      for (std::size_t b = a + 1; b < sketch_.cells.size(); ++b) {
        if (!here(b) || !sketch_.cells[b].spine) continue;
        const auto wall = shared_wall(sketch_.cells[a].box, sketch_.cells[b].box);
        if (!wall || wall->to - wall->from < 1.4) continue;
        join(a, b, OpeningKind::kArch, 1.0, 3.0);
      }
    }
  }

  bool add_room_doors() {
    const auto& cells = sketch_.cells;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (!here(c) || cells[c].spine) continue;
      const double width = door_width(cells[c].type, rng_);
      std::vector<std::size_t> to;
      if (cells[c].host) {
        to.push_back(*cells[c].host);
      } else {
        for (std::size_t s = 0; s < cells.size(); ++s) {
          if (here(s) && cells[s].spine) to.push_back(s);
        }
        rng_.shuffle(std::span(to));
      }
      const char other = to.empty() ? '-' : cells[to[0]].type;
      const bool open = is_one_of(cells[c].type, kSocial) &&
                        chance(rng_, cells[c].host && is_one_of(other, kSocial) ? 0.8 : 0.5);
      bool done = false;
      for (const std::size_t t : to) {
        if (open) done = join(c, t, OpeningKind::kArch, 1.2, draw(rng_, 1.5, 3.0));
        if (!done) done = join(c, t, OpeningKind::kDoor, 0, width);
        if (!done && width > 0.9) done = join(c, t, OpeningKind::kDoor, 0, 0.9);
        if (done) break;
      }
      if (!done) return false;
    }
    return true;
  }

  // Living rooms, dining rooms and kitchens side by side open to each other: the enfilade.
  void add_enfilades() {
    const auto& cells = sketch_.cells;
    for (std::size_t a = 0; a < cells.size(); ++a) {
      for (std::size_t b = a + 1; b < cells.size(); ++b) {
        if (!here(a) || !here(b) || joined(a, b)) continue;
        const char ta = cells[a].type, tb = cells[b].type;
        double share = 0;
        if (is_one_of(ta, "ldkf") && is_one_of(tb, "ldkf")) share = 0.6;
        if ((ta == 'd' && tb == 'k') || (ta == 'k' && tb == 'd')) share = 0.95;
        if ((ta == 'l' && is_one_of(tb, "oiv")) || (tb == 'l' && is_one_of(ta, "oiv"))) share = 0.3;
        if ((ta == 'o' && tb == 'o') || (ta == 'n' && tb == 'm')) share = 0.12;
        if ((is_one_of(ta, "yp") && is_one_of(tb, "ldb")) ||
            (is_one_of(tb, "yp") && is_one_of(ta, "ldb"))) {
          share = 0.5;
        }
        if (!chance(rng_, share)) continue;
        const bool social = is_one_of(ta, kSocial) && is_one_of(tb, kSocial);
        if (social && chance(rng_, 0.7)) {
          if (join(a, b, OpeningKind::kArch, 1.3, draw(rng_, 1.6, 3.0))) continue;
        }
        join(a, b, OpeningKind::kDoor, 0, snap(draw(rng_, 0.9, 1.0)));
      }
    }
  }

  bool add_entrances() {
    bool found = false;
    for (std::size_t r = 0; r < sketch_.cells.size(); ++r) {
      const bool garage = sketch_.cells[r].type == 'g';
      const bool entry = sketch_.cells[r].type == 'e' && sketch_.cells[r].spine && !found;
      if (storey_ > 0 || (!garage && !entry)) continue;
      auto o = outer_wall(sketch_, r, sketch_.front);
      if (!o) continue;
      o->kind = OpeningKind::kEntrance;
      const Rect& floor = plan_.rooms[r].floor;
      const auto [lo, hi] = floor.range(o->along_x);
      const double width =
          garage ? std::min(2.8, hi - lo - 0.5) : std::min(1.1, hi - lo - 2 * kNib);
      const double slack = hi - lo - 2 * kNib - width;
      o->from = lo + kNib + slack * (garage ? 0.5 : draw(rng_, 0.3, 0.7));
      o->to = o->from + width;
      o->head = garage ? 2.2 : 2.1;
      if (!clear_of_flight(opening_zone(plan_, *o), sketch_.flight)) return false;
      plan_.openings.push_back(*o);
      found = found || entry;
    }
    return found || storey_ > 0;
  }

  void add_windows(std::size_t room, Side side, bool must) {
    auto o = outer_wall(sketch_, room, side);
    if (!o) return;
    const char type = sketch_.cells[room].type;
    const WindowKind kind = window_kind(type, tall_windows_);
    if (!must && !chance(rng_, kind.share)) return;
    o->kind = OpeningKind::kWindow;
    const double ceiling = plan_.rooms[room].ceiling;
    o->sill = kind.sill;
    o->head = std::min(kind.head, ceiling - 0.2);
    const Rect& floor = plan_.rooms[room].floor;
    const auto [lo, hi] = floor.range(o->along_x);
    auto free = free_wall(*o, lo, hi, 0.3);
    for (const Opening& p : plan_.openings) {  // no window behind an open leaf
      const auto leaf = leaf_zone(plan_, p);
      if (!leaf || !here(p.room0)) continue;
      if (!overlap(*leaf, both_sides(o->along_x, o->wall, lo, hi, 0.6))) continue;
      const auto [from, to] = leaf->range(o->along_x);
      take_out(free, from - 0.1, to + 0.1);
    }
    const double width = snap(draw(rng_, kind.low, kind.high));
    for (const auto& [a, b] : free) {
      const double least = std::min(width, 0.5);
      if (b - a < least) continue;
      const double each = std::min(width, b - a);
      const auto fit = static_cast<int>((b - a + kind.spacing) / (each + kind.spacing));
      const int count = std::clamp(fit, 1, 12);
      const double pitch = (b - a) / count;
      for (int i = 0; i < count; ++i) {
        const double middle = a + pitch * (i + 0.5);
        o->from = middle - each / 2;
        o->to = middle + each / 2;
        plan_.openings.push_back(*o);
      }
      if (is_one_of(type, "atcjuz")) return;
    }
  }

  void add_windows(std::size_t room) {
    // The longest outer wall has one in any case, where people stay.
    std::vector<std::pair<double, Side>> sides;
    for (const Side side : kSides) {
      if (!outer_wall(sketch_, room, side)) continue;
      const Rect& f = plan_.rooms[room].floor;
      sides.emplace_back(-f.length(runs_along_x(side)), side);
    }
    std::sort(sides.begin(), sides.end());
    const bool stay = is_one_of(sketch_.cells[room].type, "bdfiklnorvwmCSpy");
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const std::size_t before = plan_.openings.size();
      add_windows(room, sides[i].second, i == 0 && stay);
      if (is_one_of(sketch_.cells[room].type, "atcjuz") && plan_.openings.size() > before) return;
    }
  }

  const Sketch& sketch_;
  Plan& plan_;
  unsigned storey_;
  Rng& rng_;
  bool tall_windows_ = false;
  double door_head_ = 2.05;
};

}  // namespace

double wall_thickness(const Plan& plan, const Opening& opening) {
  return opening.room1 ? plan.inner_wall : plan.outer_wall;
}

Rect opening_zone(const Plan& plan, const Opening& o) {
  return both_sides(o.along_x, o.wall, o.from, o.to, kStand + wall_thickness(plan, o) / 2);
}

std::optional<Rect> leaf_zone(const Plan& plan, const Opening& o) {
  if (o.leaf <= 0 || !o.room1) return std::nullopt;
  // A leaf of 4 cm that stands within a few degrees of a right angle, and its handle.
  constexpr double kLeafSpace = 0.14;
  const double hinge = o.hinge_at_to ? o.to : o.from;
  const double face = wall_thickness(plan, o) / 2, reach = face + (o.to - o.from);
  const double n0 = o.leaf_in_room1 ? o.wall + face : o.wall - reach;
  const double n1 = o.leaf_in_room1 ? o.wall + reach : o.wall - face;
  const double a0 = hinge - kLeafSpace, a1 = hinge + kLeafSpace;
  return laid_rect(o.along_x, a0, a1, n0, n1);
}

bool add_openings(const Sketch& sketch, Plan& plan, Rng& rng) {
  for (unsigned s = 0; s < plan.storeys.size(); ++s) {
    Openings openings(sketch, plan, s, rng);
    if (!openings.add()) return false;
  }
  return true;
}

}  // namespace enfilade::homes::plan
