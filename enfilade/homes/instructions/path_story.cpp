#include "enfilade/homes/instructions/path_story.h"

#include <algorithm>
#include <cmath>

#include "enfilade/geometry/angle.h"
#include "enfilade/homes/instructions/naming.h"

namespace enfilade::homes::instructions {
namespace {

constexpr double kStep = 0.35;         // metres: a leg that rises by more is on stairs
constexpr double kOnFloor = 0.3;       // metres above or below a storey's floor that count as on it
constexpr double kClearlyAside = 0.2;  // least metres from the line walked to a thing's box
constexpr double kPassedWithin = 2.2;  // metres to its nearest corner
constexpr double kSeenShare = 0.0008;  // of the sphere: about 7 of 8,192 rays
constexpr double kAroundShare = 0.002;  // of things that describe the start or the end
constexpr double kOverhead = 1.9;       // metres: things that hang higher are not passed
constexpr double kReach = 1.6;          // metres to a thing that the path ends by
constexpr double kInDoorway = 0.4, kByDoor = 1.2, kByStairs = 1.5, kJustInside = 2.5;

constexpr double kPlainTurn = 40;  // degrees
constexpr double kTouch = 0.7;     // metres there and back

struct Flat {
  double x = 0, y = 0;
  friend Flat operator-(Flat a, Flat b) { return {a.x - b.x, a.y - b.y}; }
};
double dot(Flat a, Flat b) { return a.x * b.x + a.y * b.y; }
// How far b lies to the right of the line through 0 in direction a.
double right_of(Flat a, Flat b) { return a.y * b.x - a.x * b.y; }

double gap(const Vec3d& low, const Vec3d& high, Flat p) {
  return std::hypot(std::max({low.x - p.x, 0.0, p.x - high.x}),
                    std::max({low.y - p.y, 0.0, p.y - high.y}));
}

Flat middle(const HomeThing& t) { return {(t.low.x + t.high.x) / 2, (t.low.y + t.high.y) / 2}; }

double bearing(Flat from, double facing, Flat to) {
  const Flat d = to - from;
  return to_degrees(wrap_difference(Radians(std::atan2(d.x, d.y) - facing)));
}

// Distance along the floor from a point to an opening, on the middle line of its wall.
double gap(const Opening& o, Flat p) {
  const double along = o.along_x ? p.x : p.y, across = o.along_x ? p.y : p.x;
  return std::hypot(std::max({o.from - along, 0.0, along - o.to}), across - o.wall);
}

Flat middle(const Opening& o) {
  const double m = (o.from + o.to) / 2;
  return o.along_x ? Flat{m, o.wall} : Flat{o.wall, m};
}

bool joins_rooms(const Opening& o) {
  return o.room1 && (o.kind == OpeningKind::kDoor || o.kind == OpeningKind::kArch);
}

class Teller {
 public:
  Teller(const SpokenHome& home, std::span<const ViewpointIndex> path, double heading)
      : home_(home), plan_(home.home.plan), path_(path), start_heading_(heading) {}

  PathStory tell() {
    story_.start = start();
    room_ = room_at(0);
    double facing = start_heading_;
    for (std::size_t i = 0; i + 1 < path_.size(); ++i) {
      const double heading = leg_heading(i, facing);
      add_leg(i, heading, to_degrees(wrap_difference(Radians(heading - facing))));
      facing = heading;
    }
    drop_touches();
    for (std::size_t i = 0; i < story_.stretches.size(); ++i) finish(i);
    story_.end = end(facing);
    if (story_.end.in_opening) stay_in_doorway(*story_.end.in_opening);
    return std::move(story_);
  }

 private:
  Flat at(std::size_t i) const {
    const Vec3f p = home_.graph.position(path_[i]);
    return {static_cast<double>(p.x), static_cast<double>(p.y)};
  }
  double floor_at(std::size_t i) const {
    return static_cast<double>(home_.graph.position(path_[i]).z) -
           static_cast<double>(home_.graph.height(path_[i]));
  }
  std::size_t room_at(std::size_t i) const { return home_.sights.room(path_[i]).value_or(0); }
  bool on_storey(std::size_t i) const {
    return std::ranges::any_of(plan_.storeys, [&](const PlanStorey& s) {
      return std::abs(s.floor - floor_at(i)) < kOnFloor;
    });
  }
  double leg_heading(std::size_t i, double facing) const {
    const Flat d = at(i + 1) - at(i);
    return dot(d, d) > 1e-6 ? std::atan2(d.x, d.y) : facing;
  }
  const HomeThing& thing(std::size_t i) const { return home_.home.things[i]; }

  // Adds leg i to the last stretch or begins a new one.
  void add_leg(std::size_t i, double heading, double turn) {
    const double rise = floor_at(i + 1) - floor_at(i);
    const int climb = rise > kStep ? 1 : rise < -kStep ? -1 : 0;
    const double bend = to_degrees(wrap_difference(Radians(heading - stretch_heading_)));
    const bool goes_on = !story_.stretches.empty() && story_.stretches.back().climb == climb &&
                         turn_of(turn) == TurnKind::kStraight &&
                         turn_of(bend) == TurnKind::kStraight && (climb == 0 || !on_storey(i));
    if (!goes_on) {
      PathStretch fresh;
      fresh.turn = turn;
      fresh.climb = climb;
      fresh.from_storey = on_storey(i);
      fresh.first = i;
      fresh.room = room_at(i);
      story_.stretches.push_back(fresh);
      stretch_heading_ = heading;
    }
    PathStretch& stretch = story_.stretches.back();
    const std::size_t before = stretch.happenings.size();
    add_crossings(i, stretch);
    add_things(i, heading, stretch);
    std::ranges::stable_sort(stretch.happenings.begin() + static_cast<std::ptrdiff_t>(before),
                             stretch.happenings.end(), {}, &Happening::metres);
    const Flat d = at(i + 1) - at(i);
    stretch.metres += std::hypot(d.x, d.y);
    if (!goes_on) stretch.first_leg = stretch.metres;
    stretch.last = i + 1;
    stretch.to_storey = on_storey(i + 1);
    stretch.room_after = room_at(i + 1);
  }

  bool stands_in_room(std::size_t i) const {
    return plan_.rooms[room_at(i)].floor.contains(at(i).x, at(i).y);
  }

  void add_crossings(std::size_t i, PathStretch& stretch) {
    const Flat a = at(i), b = at(i + 1);
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    std::vector<Happening> found;
    for (std::size_t k = 0; k < plan_.openings.size(); ++k) {
      const Opening& o = plan_.openings[k];
      if (!joins_rooms(o)) continue;
      const double p = (o.along_x ? a.y : a.x) - o.wall, q = (o.along_x ? b.y : b.x) - o.wall;
      if ((p >= 0) == (q >= 0)) continue;
      const double share = p / (p - q);
      const double along = o.along_x ? a.x + share * (b.x - a.x) : a.y + share * (b.y - a.y);
      if (along < o.from || along > o.to) continue;
      const double z = floor_at(i) + share * (floor_at(i + 1) - floor_at(i));
      if (std::abs(z - plan_.storeys[plan_.rooms[o.room0].storey].floor) > 0.6) continue;
      Happening crossing;
      crossing.metres = stretch.metres + share * length;
      crossing.opening = k;
      crossing.from = p < 0 ? o.room0 : *o.room1;
      crossing.to = p < 0 ? *o.room1 : o.room0;
      found.push_back(crossing);
    }
    std::ranges::stable_sort(found, {}, &Happening::metres);
    for (const Happening& crossing : found) room_ = crossing.to;
    // A viewpoint in a doorway is in neither room; the next leg decides.
    if (stands_in_room(i + 1) && room_ != room_at(i + 1)) {
      if (stands_in_room(i) && stretch.climb == 0) {
        Happening crossing;  // rooms that meet without a wall
        crossing.metres = stretch.metres + length;
        crossing.from = room_;
        crossing.to = room_at(i + 1);
        found.push_back(crossing);
      }
      room_ = room_at(i + 1);
    }
    stretch.happenings.insert(stretch.happenings.end(), found.begin(), found.end());
  }

  // Removes crossings of a path that enters a doorway and turns back.
  void drop_touches() {
    Happening* before = nullptr;
    double walked = 0, when = 0;  // metres; of the crossing before
    for (PathStretch& s : story_.stretches) {
      for (Happening& h : s.happenings) {
        if (h.kind != HappeningKind::kCross) continue;
        const bool back = before != nullptr && before->from == h.to && before->to == h.from &&
                          walked + h.metres - when < kTouch;
        if (back) before->to = before->from, h.from = h.to;
        before = back ? nullptr : &h;
        when = walked + h.metres;
      }
      walked += s.metres;
    }
    for (PathStretch& s : story_.stretches) {
      std::erase_if(s.happenings, [](const Happening& h) {
        return h.kind == HappeningKind::kCross && h.from == h.to;
      });
    }
  }

  // A path that ends in a doorway does not go through it: removes that crossing.
  void stay_in_doorway(std::size_t opening) {
    std::vector<Happening>& all = story_.stretches.back().happenings;
    for (std::size_t k = all.size(); k-- > 0;) {
      if (all[k].kind != HappeningKind::kCross) continue;
      const bool here = all[k].opening == opening &&
                        story_.stretches.back().metres - all[k].metres < kInDoorway + 0.1;
      if (here) all.erase(all.begin() + static_cast<std::ptrdiff_t>(k));
      return;
    }
  }

  // Objects in view from a viewpoint, without rugs and objects that people do not mention.
  std::vector<Neighbour> neighbours(std::size_t i, double facing, double least_share) const {
    std::vector<Neighbour> found;
    for (const ThingInView& sight : home_.sights.at(path_[i])) {
      const HomeThing& t = thing(sight.thing);
      const double weight = sight.share * weight_of(home_.home, sight.thing);
      if (sight.share < least_share || weight <= 0 || is_rug(t)) continue;
      found.push_back(
          {sight.thing, bearing(at(i), facing, middle(t)), gap(t.low, t.high, at(i)), weight});
    }
    return found;
  }

  // Adds things beside and below leg i, seen from its start.
  void add_things(std::size_t i, double heading, PathStretch& stretch) const {
    if (stretch.climb != 0) return;
    const Flat a = at(i), u{std::sin(heading), std::cos(heading)};
    const double length = std::hypot(at(i + 1).x - a.x, at(i + 1).y - a.y);
    for (const ThingInView& sight : home_.sights.at(path_[i])) {
      const HomeThing& t = thing(sight.thing);
      Happening h;
      h.thing = sight.thing;
      h.seen_from = path_[i];
      h.salience = sight.share * weight_of(home_.home, sight.thing);
      if (sight.share < kSeenShare || h.salience <= 0) continue;
      if (t.room != room_at(i) && t.room != room_at(i + 1)) continue;
      const double along = dot(middle(t) - a, u);
      h.metres = stretch.metres + along;
      if (is_rug(t)) {
        h.kind = HappeningKind::kOver;
        if (along > 0.2 && along < length &&
            gap(t.low, t.high, {a.x + along * u.x, a.y + along * u.y}) == 0) {
          stretch.happenings.push_back(h);
        }
      } else if (along > 0.25 && along < length) {
        h.kind = HappeningKind::kPass;
        if (is_aside(t, i, u, h.on_right)) stretch.happenings.push_back(h);
      }
    }
  }

  // Whether the whole thing stands on one side of the line, near enough and not overhead.
  bool is_aside(const HomeThing& t, std::size_t i, Flat u, bool& on_right) const {
    if (t.low.z > floor_at(i) + kOverhead) return false;
    double least = 1e9, most = -1e9;
    for (const double x : {t.low.x, t.high.x}) {
      for (const double y : {t.low.y, t.high.y}) {
        const double aside = right_of(u, Flat{x, y} - at(i));
        least = std::min(least, aside);
        most = std::max(most, aside);
      }
    }
    on_right = least > 0;
    return (least > kClearlyAside && least < kPassedWithin) ||
           (most < -kClearlyAside && most > -kPassedWithin);
  }

  void finish(std::size_t k) {
    PathStretch& stretch = story_.stretches[k];
    const Flat a = at(stretch.first), b = at(stretch.last);
    const double heading = std::atan2(b.x - a.x, b.y - a.y);
    std::vector<Neighbour> ahead = neighbours(stretch.first, heading, kSeenShare);
    std::ranges::stable_sort(ahead, std::ranges::greater(), &Neighbour::salience);
    for (const Neighbour& n : ahead) {
      const Flat d = middle(thing(n.thing)) - a;
      const bool beyond = std::hypot(d.x, d.y) > std::max(1.5, stretch.metres - 0.3);
      if (std::abs(n.bearing) < 12 && beyond) stretch.ahead.push_back(n.thing);
    }
    stretch.to_end = stretch.climb == 0 && at_end_of_long(stretch.last, heading);
    stretch.door = k > 0 ? count_doors(story_.stretches[k - 1], stretch) : 0;
  }

  // Whether a viewpoint is at the end of a long and narrow room, near the short wall ahead.
  bool at_end_of_long(std::size_t i, double heading) const {
    if (plan_.rooms[room_at(i)].type == 's') return false;
    const Rect& r = plan_.rooms[room_at(i)].floor;
    const bool along_x = r.width() > r.depth();
    const double longer = std::max(r.width(), r.depth());
    if (longer < 5 || longer < 2.2 * std::min(r.width(), r.depth())) return false;
    const double u = along_x ? std::sin(heading) : std::cos(heading);
    if (std::abs(u) < 0.9) return false;
    const double p = along_x ? at(i).x : at(i).y;
    const double wall = along_x ? (u > 0 ? r.x1 : r.x0) : (u > 0 ? r.y1 : r.y0);
    return std::abs(wall - p) < 1.6;
  }

  // The doors of the room that `before` runs through, on the side to which `after` turns.
  unsigned count_doors(const PathStretch& before, const PathStretch& after) const {
    if (before.climb != 0 || after.climb != 0 || after.happenings.empty()) return 0;
    if (turn_of(after.turn) != TurnKind::kFull || before.room != after.room) return 0;
    const auto first = std::ranges::find(after.happenings, HappeningKind::kCross, &Happening::kind);
    if (first == after.happenings.end() || !first->opening || first->from != before.room) return 0;
    if (plan_.openings[*first->opening].kind != OpeningKind::kDoor) return 0;
    // Counting must begin at an obvious place: at a turn, or where the room was entered.
    if (before.first > 0 && room_at(before.first - 1) == before.room &&
        std::abs(before.turn) < kPlainTurn) {
      return 0;
    }
    const Flat a = at(before.first), d = at(before.last) - a;
    const double length = std::hypot(d.x, d.y);
    const Flat u{d.x / length, d.y / length};
    const double target = dot(middle(plan_.openings[*first->opening]) - a, u);
    unsigned count = 1;
    for (std::size_t k = 0; k < plan_.openings.size(); ++k) {
      const Opening& o = plan_.openings[k];
      if (o.kind == OpeningKind::kWindow || k == *first->opening) continue;
      if (o.room0 != before.room && o.room1 != before.room) continue;
      const Flat m = middle(o) - a;
      const double along = dot(m, u), aside = right_of(u, m);
      const bool same_side = (aside > 0) == (after.turn > 0);
      if (!same_side && std::abs(aside) > 0.4) continue;
      // If it is unclear whether a door counts, nothing is counted.
      if (std::abs(aside) < 0.4 && along > -0.8 && along < target) return 0;
      if (std::abs(along) < 0.8 || std::abs(along - target) < 0.8) return 0;
      if (along < 0 || along > target) continue;
      if (o.kind != OpeningKind::kDoor) return 0;  // is an arch a door?
      ++count;
    }
    return target > 0.8 && count <= 4 ? count : 0;
  }

  PathStart start() const {
    PathStart s{room_at(0), neighbours(0, start_heading_, kAroundShare)};
    std::erase_if(s.around, [&](const Neighbour& n) { return thing(n.thing).room != s.room; });
    std::ranges::stable_sort(s.around, std::ranges::greater(), &Neighbour::salience);
    return s;
  }

  PathEnd end(double facing) const {
    const std::size_t i = path_.size() - 1;
    PathEnd e;
    e.room = room_at(i);
    e.on_stairs = !on_storey(i);
    for (Neighbour n : neighbours(i, facing, kAroundShare)) {
      const HomeThing& t = thing(n.thing);
      if (t.room != e.room || t.low.z > floor_at(i) + kOverhead || n.gap > kReach) continue;
      n.salience /= 0.3 + n.gap;  // of the things that stand out, people stop by the nearest
      e.near.push_back(n);
    }
    std::ranges::stable_sort(e.near, std::ranges::greater(), &Neighbour::salience);
    end_by_openings(i, e);
    end_by_stairs(i, e);
    end_in_room(i, facing, e);
    return e;
  }

  void end_by_openings(std::size_t i, PathEnd& e) const {
    if (e.on_stairs) return;
    std::size_t close = 0;
    for (std::size_t k = 0; k < plan_.openings.size(); ++k) {
      const Opening& o = plan_.openings[k];
      if (o.kind == OpeningKind::kWindow || (o.room0 != e.room && o.room1 != e.room)) continue;
      const double distance = gap(o, at(i));
      if (joins_rooms(o) && distance < kInDoorway) e.in_opening = k;
      if (distance < kByDoor) e.near_opening = k;
      // With another opening hardly farther away, "the door" would be ambiguous.
      if (distance < kByDoor + 0.6) ++close;
    }
    if (close != 1) e.near_opening.reset();
  }

  void end_by_stairs(std::size_t i, PathEnd& e) const {
    if (plan_.rooms[e.room].type != 's') return;
    for (const Stairs& s : plan_.stairs) {
      const Flat low = flight_end(s, false), high = flight_end(s, true);
      const double below = std::hypot(at(i).x - low.x, at(i).y - low.y);
      const double above = std::hypot(at(i).x - high.x, at(i).y - high.y);
      const double floor = plan_.storeys[s.storey].floor, z = floor_at(i);
      if (std::abs(z - floor) < kOnFloor && below < kByStairs) e.stairs = -1;
      if (std::abs(z - floor - plan_.storeys[s.storey].height) < kOnFloor && above < kByStairs) {
        e.stairs = 1;
      }
    }
  }

  static Flat flight_end(const Stairs& s, bool high) {
    const Rect& f = s.flight;
    const double end = f.at(high ? s.climbs_towards : opposite(s.climbs_towards));
    if (faces_x(s.climbs_towards)) return {end, (f.y0 + f.y1) / 2};
    return {(f.x0 + f.x1) / 2, end};
  }

  void end_in_room(std::size_t i, double facing, PathEnd& e) const {
    const PathStretch& last = story_.stretches.back();
    for (const Happening& h : last.happenings) {
      if (h.kind != HappeningKind::kCross) continue;
      e.just_inside = last.metres - h.metres < kJustInside && h.to == e.room;
    }
    const Rect& r = plan_.rooms[e.room].floor;
    e.in_middle = std::min(r.width(), r.depth()) > 2.5 &&
                  std::abs(at(i).x - (r.x0 + r.x1) / 2) < r.width() / 6 &&
                  std::abs(at(i).y - (r.y0 + r.y1) / 2) < r.depth() / 6;
    e.at_end = at_end_of_long(i, facing);
  }

  const SpokenHome& home_;
  const Plan& plan_;
  std::span<const ViewpointIndex> path_;
  double start_heading_;
  double stretch_heading_ = 0;
  std::size_t room_ = 0;  // the current room, by the crossings so far
  PathStory story_;
};

}  // namespace

TurnKind turn_of(double degrees) {
  const double size = std::abs(degrees);
  if (size < kStraightBelow) return TurnKind::kStraight;
  if (size < kSlightBelow) return TurnKind::kSlight;
  return size < kFullBelow ? TurnKind::kFull : TurnKind::kAround;
}

PathStory tell_path(const SpokenHome& home, std::span<const ViewpointIndex> viewpoints,
                    double heading) {
  return Teller(home, viewpoints, heading).tell();
}

}  // namespace enfilade::homes::instructions
