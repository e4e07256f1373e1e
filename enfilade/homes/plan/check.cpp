#include "enfilade/homes/plan/draws.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

namespace enfilade::homes::plan {
namespace {

using Faults = std::vector<std::string>;

constexpr std::string_view kPrivate = "batc";  // nobody passes these on the way to others

std::string name(const Plan& plan, std::size_t room) {
  const PlanRoom& r = plan.rooms[room];
  return fmt::format("room {} ({}, storey {})", room, r.name, r.storey);
}

void check_rooms(const Plan& plan, Faults& faults) {
  for (std::size_t a = 0; a < plan.rooms.size(); ++a) {
    const PlanRoom& r = plan.rooms[a];
    const Rect &f = r.floor, &out = plan.outline;
    const double wall = plan.outer_wall - 1e-6;
    if (f.x0 < out.x0 + wall || f.x1 > out.x1 - wall || f.y0 < out.y0 + wall ||
        f.y1 > out.y1 - wall) {
      faults.push_back(name(plan, a) + " is not within the outer walls");
    }
    const double side = std::min(f.width(), f.depth()),
                 aspect = std::max(f.width(), f.depth()) / side;
    const bool corridor = is_one_of(r.type, "hse");
    const double least = is_one_of(r.type, "tcaehsujzyp") ? 1.2 : 2.4;
    if (side < least) faults.push_back(fmt::format("{} is {:.2f} m narrow", name(plan, a), side));
    if (!corridor && aspect > 2.8) {
      faults.push_back(fmt::format("{} has an aspect of {:.2f}", name(plan, a), aspect));
    }
    if (r.ceiling < 2.4 || r.ceiling > 3.4 || r.ceiling > plan.storeys[r.storey].height - 0.2) {
      faults.push_back(fmt::format("{} has a ceiling at {} m", name(plan, a), r.ceiling));
    }
    for (std::size_t b = 0; b < a; ++b) {
      const Rect& g = plan.rooms[b].floor;
      const double t = plan.inner_wall - 1e-6;
      const Rect wide{g.x0 - t, g.y0 - t, g.x1 + t, g.y1 + t};
      if (plan.rooms[b].storey == r.storey && overlap(f, wide)) {
        faults.push_back(name(plan, a) + " lies less than a wall from " + name(plan, b));
      }
    }
  }
}

bool fits_room(const Plan& plan, const Opening& o, std::size_t room, bool lower) {
  const Rect& f = plan.rooms[room].floor;
  const double half = wall_thickness(plan, o) / 2;
  const auto [low_face, high_face] = f.range(!o.along_x);
  const double face = lower ? high_face : low_face;
  const auto [lo, hi] = f.range(o.along_x);
  const double nib = 0.15 - 1e-6;
  return std::abs(face - (lower ? o.wall - half : o.wall + half)) < 1e-6 && o.from >= lo + nib &&
         o.to <= hi - nib && o.head <= plan.rooms[room].ceiling - 0.1;
}

void check_opening(const Plan& plan, std::size_t i, Faults& faults) {
  const Opening& o = plan.openings[i];
  const auto say = [&](const char* what) {
    faults.push_back(fmt::format("opening {} of {} {}", i, name(plan, o.room0), what));
  };
  const double width = o.to - o.from;
  const bool fits = o.room1
                        ? fits_room(plan, o, o.room0, true) && fits_room(plan, o, *o.room1, false)
                        : fits_room(plan, o, o.room0, true) || fits_room(plan, o, o.room0, false);
  if (!fits) say("is not in its wall");
  const bool window = o.kind == OpeningKind::kWindow;
  if (!window && (width < 0.88 || o.head < 1.95)) say("is too small for a door");
  if (window && (width < 0.4 || o.head - o.sill < 0.4 || o.sill < 0.3)) say("is no good window");
  if (o.kind == OpeningKind::kArch && (width < 1.0 || width > 3.0 + 1e-9)) say("is no arch");
  for (const Stairs& s : plan.stairs) {
    const unsigned storey = plan.rooms[o.room0].storey;
    if (window || (storey != s.storey && storey != s.storey + 1)) continue;
    if (overlap(opening_zone(plan, o), s.flight)) say("opens onto a flight's side");
  }
  for (std::size_t j = 0; j < plan.openings.size(); ++j) {
    const Opening& p = plan.openings[j];
    if (j == i || plan.rooms[p.room0].storey != plan.rooms[o.room0].storey) continue;
    if (j < i && p.along_x == o.along_x && std::abs(p.wall - o.wall) < 1e-6 &&
        p.from < o.to + 0.2 && o.from < p.to + 0.2) {
      say("meets another one");
    }
    const auto leaf = leaf_zone(plan, p);
    if (!window && leaf && overlap(*leaf, opening_zone(plan, o))) say("is behind an open leaf");
  }
}

// Rooms reached from `start` through openings, by rooms that are not private and by stairs.
std::vector<bool> reached_from(const Plan& plan, std::size_t start, bool private_ends) {
  std::vector<bool> reached(plan.rooms.size(), false);
  std::vector<std::size_t> open{start};
  reached[start] = true;
  const auto step = [&](std::size_t from, std::size_t to) {
    if (reached[to]) return;
    const bool end = is_one_of(plan.rooms[to].type, kPrivate);
    if (end && !private_ends) return;
    // A bath, a closet or a balcony may be a bedroom's own.
    const bool own = plan.rooms[from].type == 'b' && is_one_of(plan.rooms[to].type, "acyp");
    if (is_one_of(plan.rooms[from].type, kPrivate) && !own) return;
    reached[to] = true;
    open.push_back(to);
  };
  while (!open.empty()) {
    const std::size_t at = open.back();
    open.pop_back();
    for (const Opening& o : plan.openings) {
      if (!o.room1) continue;
      if (o.room0 == at) step(at, *o.room1);
      if (*o.room1 == at) step(at, o.room0);
    }
    for (const Stairs& s : plan.stairs) {
      if (s.room_below == at) step(at, s.room_above);
      if (s.room_above == at) step(at, s.room_below);
    }
  }
  return reached;
}

void check_ways(const Plan& plan, Faults& faults) {
  std::optional<std::size_t> front;
  for (const Opening& o : plan.openings) {
    if (o.kind == OpeningKind::kEntrance && plan.rooms[o.room0].type == 'e') front = o.room0;
  }
  if (!front) {
    faults.emplace_back("there is no front door");
    return;
  }
  const auto reached = reached_from(plan, *front, true);
  for (std::size_t r = 0; r < plan.rooms.size(); ++r) {
    if (!reached[r]) faults.push_back(name(plan, r) + " is out of reach");
  }
}

bool has_outer_wall(const Plan& plan, const Rect& f, double least) {
  const double t = plan.outer_wall + 1e-6;
  const Rect& o = plan.outline;
  return ((f.x0 < o.x0 + t || f.x1 > o.x1 - t) && f.depth() >= least) ||
         ((f.y0 < o.y0 + t || f.y1 > o.y1 - t) && f.width() >= least);
}

void check_windows(const Plan& plan, Faults& faults) {
  for (std::size_t r = 0; r < plan.rooms.size(); ++r) {
    const PlanRoom& room = plan.rooms[r];
    if (!is_one_of(room.type, "bdfklorC") || !has_outer_wall(plan, room.floor, 0)) {
      if (is_one_of(room.type, "bdfklC")) faults.push_back(name(plan, r) + " has no outer wall");
      continue;
    }
    const bool any = std::any_of(plan.openings.begin(), plan.openings.end(), [&](const Opening& o) {
      return o.kind == OpeningKind::kWindow && o.room0 == r;
    });
    if (!any) faults.push_back(name(plan, r) + " has no window");
  }
}

void check_stairs(const Plan& plan, Faults& faults) {
  for (const Stairs& s : plan.stairs) {
    const bool x = faces_x(s.climbs_towards);
    const double going = s.flight.length(x) / s.steps;
    const double rise = plan.storeys[s.storey].height / s.steps;
    if (going < 0.25 - 1e-9 || rise > 0.19) {
      faults.push_back(fmt::format("stairs with steps of {:.3f} by {:.3f} m", going, rise));
    }
    for (const std::size_t r : {s.room_below, s.room_above}) {
      const Rect& f = plan.rooms[r].floor;
      if (plan.rooms[r].type != 's') faults.push_back(name(plan, r) + " has stairs");
      const auto [floor0, floor1] = f.range(x);
      const auto [flight0, flight1] = s.flight.range(x);
      const double before = flight0 - floor0, behind = floor1 - flight1;
      const double beside = f.length(!x) - s.flight.length(!x);
      if (before < 0.9 || behind < 0.9 || beside < 1.2) {
        faults.push_back(fmt::format("{}: stairs have {:.2f}, {:.2f} and {:.2f} m around them",
                                     name(plan, r), before, behind, beside));
      }
    }
  }
  for (unsigned s = 0; s + 1 < plan.storeys.size(); ++s) {
    const bool any = std::any_of(plan.stairs.begin(), plan.stairs.end(),
                                 [&](const Stairs& t) { return t.storey == s; });
    if (!any) faults.push_back(fmt::format("no stairs lead up from storey {}", s));
  }
}

}  // namespace

std::vector<std::string> plan_faults(const Plan& plan) {
  Faults faults;
  check_rooms(plan, faults);
  for (std::size_t i = 0; i < plan.openings.size(); ++i) check_opening(plan, i, faults);
  check_ways(plan, faults);
  check_windows(plan, faults);
  check_stairs(plan, faults);
  return faults;
}

}  // namespace enfilade::homes::plan
