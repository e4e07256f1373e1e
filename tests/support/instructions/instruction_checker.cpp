#include "tests/support/instructions/instruction_checker.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "tests/support/instructions/instruction_reader.h"

namespace enfilade::homes::instructions::testing {
namespace {

// Degrees. People's words are wide: "left" may be anything from half to one and a half right
// angles, and what bends by more than 75 is a turn that must not be left out.
constexpr double kLeastSharp = 90, kLeastTurn = 40, kMostTurn = 150, kLeastSlight = 8,
                 kMostSlight = 75;
constexpr double kLeastAround = 115, kMostStraight = 50, kMustBeSaid = 75;
// Metres: anyone on the stairs is at least one step off a floor; at their end, at most two.
constexpr double kThere = 0.2, kAboutThere = 0.45;
constexpr double kOrder = 0.06;  // legs: things that lie side by side come in either order

// One instruction against one path.
class Walk : private Route {
 public:
  using Route::Route;

  std::vector<std::string> follow(const Reading& reading) {
    for (const std::string& word : reading.not_understood) wrong("not understood: " + word);
    check_from(reading.claims);
    if (reading.claims.empty() || !stopped_) wrong("never says to stop");
    return std::move(faults_);
  }

 private:
  using Kind = Claim::Kind;

  void wrong(const std::string& text) { faults_.push_back(text); }
  // Is it the only thing of its name that one could mean there?
  bool is_the_one(const ThingNamed& named, std::size_t viewpoint, std::size_t thing) const {
    return sees(viewpoint, thing) && std::ranges::none_of(named.fits, [&](std::size_t other) {
             return other != thing && sees_well(viewpoint, other);
           });
  }
  std::optional<std::size_t> the_one(const ThingNamed& named, std::size_t viewpoint) const {
    for (const std::size_t thing : named.fits) {
      if (is_the_one(named, viewpoint, thing)) return thing;
    }
    return std::nullopt;
  }

  // --- moving on ----------------------------------------------------------------------------
  // Nothing that must be said lies between now and then.
  bool nothing_skipped(double then) const {
    for (std::size_t i = 0; i < legs(); ++i) {
      const auto when = static_cast<double>(i);
      if (when >= now_ && when < then && !turned_[i] && std::abs(turns_[i]) >= kMustBeSaid) {
        return false;
      }
    }
    return true;
  }
  bool go_to(double then, const std::string& what) {
    if (!nothing_skipped(then)) {
      wrong(what + ": a turn before it is not said");
      return false;
    }
    now_ = std::max(now_, then);
    return true;
  }

  // A slight bend may be any of those to come: the first that makes the rest true.
  void check_from(std::span<const Claim> claims) {
    while (!claims.empty()) {
      const Claim& c = claims.front();
      claims = claims.subspan(1);
      if (c.kind == Kind::kTurn && c.slight && bends(c.side).size() > 1) {
        const Walk before = *this;
        for (const std::size_t i : bends(c.side)) {
          *this = before;
          if (go_to(static_cast<double>(i), "turn")) turned_[i] = true;
          check_from(claims);
          if (faults_.size() == before.faults_.size()) return;
        }
        return;
      }
      check(c);
    }
  }
  std::vector<std::size_t> bends(Side side) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < legs(); ++i) {
      if (static_cast<double>(i) >= now_ && !turned_[i] && fits_turn(turns_[i], side, true)) {
        found.push_back(i);
      }
    }
    return found;
  }

  void check(const Claim& c) {
    switch (c.kind) {
      case Kind::kTurn:
        turn(c.side, c.slight);
        if (c.sharp && !is_sharp(c.side)) wrong("no sharp turn");
        break;
      case Kind::kAround:
        around();
        break;
      case Kind::kStraight:
        straight();
        break;
      case Kind::kCross:
        cross(c);
        break;
      case Kind::kInside:
        inside(c);
        break;
      case Kind::kEndOf:
        end_of(c);
        break;
      case Kind::kStairs:
        stairs(c);
        break;
      case Kind::kUpstairs:
        upstairs(c);
        break;
      case Kind::kTop:
        flight_end(c);
        break;
      case Kind::kPass:
        pass(c.thing, c.side);
        break;
      case Kind::kBetween:
        between(c);
        break;
      case Kind::kOver:
        over(c);
        break;
      case Kind::kTowards:
        towards(c);
        break;
      case Kind::kAhead:
      case Kind::kBehind:
      case Kind::kBeside:
        stands(c);
        break;
      case Kind::kNear:
        near(c);
        break;
      case Kind::kInDoorway:
      case Kind::kByDoor:
        by_door(c);
        break;
      case Kind::kMiddle:
        in_middle(c);
        break;
      case Kind::kOnStairs:
        on_stairs();
        break;
      case Kind::kWalk:
        distance(c);
        break;
      case Kind::kStop:
        stop();
        break;
    }
  }

  static bool fits_turn(double degrees, Side side, bool slight) {
    const double d = side == Side::kRight ? degrees : -degrees;
    return slight ? d >= kLeastSlight && d <= kMostSlight : d >= kLeastTurn && d <= kMostTurn;
  }

  bool turn(Side side, bool slight) {
    for (std::size_t i = 0; i < legs(); ++i) {
      const auto when = static_cast<double>(i);
      if (when < now_ || turned_[i]) continue;
      if (!fits_turn(turns_[i], side, slight)) continue;
      if (!go_to(when, "turn")) return false;
      turned_[i] = true;
      return true;
    }
    wrong("no such turn");
    return false;
  }
  // Of the turn that was said last.
  bool is_sharp(Side side) const {
    const auto i = static_cast<std::size_t>(now_);
    return i < legs() && turned_[i] &&
           (side == Side::kRight ? turns_[i] : -turns_[i]) >= kLeastSharp;
  }
  void around() {
    for (std::size_t i = 0; i < legs(); ++i) {
      const auto when = static_cast<double>(i);
      if (when < now_ || turned_[i] || std::abs(turns_[i]) < kLeastAround) continue;
      turned_[i] = true;
      go_to(when, "turn around");
      return;
    }
    wrong("nobody turns around");
  }
  void straight() {
    const auto i = static_cast<std::size_t>(std::ceil(now_ - 1e-9));
    if (std::abs(now_ - static_cast<double>(i)) > 1e-9 || i >= legs() || turned_[i]) return;
    if (std::abs(turns_[i]) > kMostStraight) wrong("not straight");
  }

  void cross(const Claim& c) {
    if (c.side != Side::kNone && !turn(c.side, false)) return;
    // A turn of the same sentence may come with the door that one turns to.
    for (const Passage& p : passages_) {
      if (p.when < now_ || (p.when == last_passage_)) continue;
      if (c.from && !c.from->contains(p.from)) continue;
      if (c.to && !c.to->contains(p.to)) continue;
      if (c.by_opening && !fits_opening(c, p)) continue;
      const double left_from = now_;
      if (!go_to(std::max(p.left, now_), "go into another room")) return;
      if (c.nth > 0 && doors_to(p, c.side) != c.nth) {
        wrong(fmt::format("door {} is number {} (from {:.2f})", c.nth, doors_to(p, c.side),
                          left_from));
      }
      if (c.another && !is_another(p, *c.to)) wrong("not another room of that name");
      last_passage_ = p.when;
      return;
    }
    std::string ways;
    for (const Passage& p : passages_) {
      ways += fmt::format(" {}:{}-{}{}", p.when, home_->plan.rooms[p.from].name,
                          home_->plan.rooms[p.to].name, p.opening ? "" : "?");
    }
    wrong(fmt::format("no such way into another room at {} of{}", now_, ways));
  }
  // Has one been in a room of that name, but never in this one?
  bool is_another(const Passage& entry, const std::set<std::size_t>& named) const {
    bool in_one = named.contains(room(at(0)));
    bool in_this = room(at(0)) == entry.to;
    for (const Passage& p : passages_) {
      if (p.when >= entry.when) break;
      in_one = in_one || named.contains(p.to);
      in_this = in_this || (p.to == entry.to && !p.slight);
    }
    return in_one && !in_this;
  }
  bool fits_opening(const Claim& c, const Passage& p) const {
    if (!p.opening) return false;
    return !c.opening || home_->plan.openings[*p.opening].kind == *c.opening;
  }

  // Which door it is on its side, counted from where one began to walk straight in this room.
  unsigned doors_to(const Passage& p, Side side) const {
    const auto corner = static_cast<std::size_t>(p.when);
    std::size_t from = corner;
    while (from > 0 && room(at(static_cast<double>(from - 1))) == p.from &&
           (from == corner || std::abs(turns_[from]) < 30)) {
      --from;
    }
    if (from == corner) return 0;
    const double h = std::atan2(eyes_[corner].x - eyes_[from].x, eyes_[corner].y - eyes_[from].y);
    const auto relative = [&](const Opening& o) {
      const double m = (o.from + o.to) / 2;
      const double x = (o.along_x ? m : o.wall) - eyes_[from].x;
      const double y = (o.along_x ? o.wall : m) - eyes_[from].y;
      return std::pair{x * std::sin(h) + y * std::cos(h), x * std::cos(h) - y * std::sin(h)};
    };
    const double here = relative(home_->plan.openings[*p.opening]).first;
    unsigned count = 1;
    for (std::size_t k = 0; k < home_->plan.openings.size(); ++k) {
      const Opening& o = home_->plan.openings[k];
      if (k == *p.opening || o.kind == OpeningKind::kWindow) continue;
      if (o.room0 != p.from && o.room1 != p.from) continue;
      const auto [along, aside] = relative(o);
      if (along > 0 && along < here && (aside > 0) == (side == Side::kRight)) ++count;
    }
    return count;
  }

  void inside(const Claim& c) {
    if (!c.to) {  // by the stairs
      if (home_->plan.rooms[room(at(end()))].type != 's') wrong("not by the stairs");
      return;
    }
    if (c.at_stop) {
      if (!c.to->contains(room(at(end())))) wrong("ends in another room");
      return;
    }
    for (double when = now_; when <= end() + 1e-9; when += 0.01) {
      const bool in_door = std::ranges::any_of(passages_, [&](const Passage& p) {
        return c.to->contains(p.to) && p.left <= when && when <= p.when;
      });
      if (!in_door && !c.to->contains(room(at(when)))) continue;
      go_to(when, "be in a room");
      return;
    }
    wrong("never in that room");
  }

  void end_of(const Claim& c) {
    for (std::size_t i = c.at_stop ? legs() : static_cast<std::size_t>(std::ceil(now_));
         i <= legs(); ++i) {
      if (i == 0) continue;
      const Rect& r = home_->plan.rooms[room(at(static_cast<double>(i)))].floor;
      const double h = headings_[i - 1];
      const double x = std::sin(h) > 0 ? r.x1 - eyes_[i].x : eyes_[i].x - r.x0;
      const double y = std::cos(h) > 0 ? r.y1 - eyes_[i].y : eyes_[i].y - r.y0;
      const double ahead = std::abs(std::sin(h)) > std::abs(std::cos(h)) ? x : y;
      if (!c.to->contains(room(at(static_cast<double>(i)))) || ahead > 1.9) continue;
      // The way to it may begin with a turn that was said, not with one that was not.
      go_to(static_cast<double>(i) - 0.01, "the end of a room");
      return;
    }
    wrong("no end of that room");
  }

  void stairs(const Claim& c) {
    for (auto i = static_cast<std::size_t>(now_ + 1e-9); i < legs(); ++i) {
      const double rise = floors_[i + 1] - floors_[i];
      if (std::abs(rise) < 0.3) continue;
      if ((rise > 0) != c.up) break;
      if (!go_to(static_cast<double>(i), "stairs")) return;
      std::size_t k = i + 1;
      while (!c.partly && k < legs() && std::abs(floors_[k + 1] - floors_[k]) > 0.3 &&
             !(std::abs(floors_[k] - floors_[i]) > 1 && on_storey(k, kAboutThere)) &&
             (floors_[k + 1] > floors_[k]) == c.up) {
        ++k;
      }
      if (c.to_end && !on_storey(k, kAboutThere)) wrong("not to the end of the stairs");
      // What lies on the last leg of the flight, a door at its top, is still to come.
      now_ = std::max(now_, static_cast<double>(k) - 0.99);
      return;
    }
    wrong("no such stairs");
  }
  bool on_storey(std::size_t i, double off) const {
    return std::ranges::any_of(home_->plan.storeys, [&](const PlanStorey& s) {
      return std::abs(s.floor - floors_[i]) < off;
    });
  }
  void upstairs(const Claim& c) {
    const double z = floors_[std::min(static_cast<std::size_t>(std::ceil(now_)), legs())];
    if (c.up == (storey(z) == 0) && home_->plan.storeys.size() < 3) wrong("on the other floor");
  }
  void flight_end(const Claim& c) {
    const std::size_t i =
        c.at_stop ? legs() : std::min(static_cast<std::size_t>(std::ceil(now_)), legs());
    const Point p = eyes_[i];
    const bool there = std::ranges::any_of(home_->plan.stairs, [&](const Stairs& s) {
      const double floor = home_->plan.storeys[c.up ? s.storey + 1 : s.storey].floor;
      const double far = std::hypot(outside(p.x, s.flight.x0, s.flight.x1),
                                    outside(p.y, s.flight.y0, s.flight.y1));
      return std::abs(floors_[i] - floor) < kAboutThere && far < (c.at_stop ? 1.7 : 4);
    });
    const bool in_stairs = home_->plan.rooms[room(at(end()))].type == 's';
    if (c.at_stop && !in_stairs) wrong("ends in no room with stairs");
    if (!there) wrong("not at that end of the stairs");
  }

  // When a thing that stands on a side of leg i is passed.
  std::optional<double> passed(std::size_t thing, std::size_t i, Side side) const {
    const HomeThing& t = home_->things[thing];
    const Point a = eyes_[i], b = eyes_[i + 1], m = middle(t);
    const double length = std::hypot(b.x - a.x, b.y - a.y), h = headings_[i];
    const double along = (m.x - a.x) * std::sin(h) + (m.y - a.y) * std::cos(h);
    const double aside = (m.x - a.x) * std::cos(h) - (m.y - a.y) * std::sin(h);
    if (along < 0.1 || along > length + 0.1) return std::nullopt;
    if (side == Side::kRight && aside < 0.1) return std::nullopt;
    if (side == Side::kLeft && aside > -0.1) return std::nullopt;
    const Point beside{a.x + along * std::sin(h), a.y + along * std::cos(h), 0};
    if (gap_to(t, beside) > 2.5) return std::nullopt;
    return static_cast<double>(i) + along / length;
  }

  bool pass(const ThingNamed& named, Side side) {
    bool ambiguous = false;
    for (auto i = static_cast<std::size_t>(now_ + 1e-9); i < legs(); ++i) {
      std::optional<double> first;
      for (const std::size_t thing : named.fits) {
        const auto when = passed(thing, i, side);
        if (!when || *when < now_ - kOrder || !sees(i, thing)) continue;
        if (!is_the_one(named, i, thing)) {
          ambiguous = true;
          continue;
        }
        first = std::min(first.value_or(1e9), *when);
      }
      if (!first) continue;
      // The turn at the viewpoint before must have been said; it is before the thing.
      return go_to(std::max(*first, static_cast<double>(i) + 1e-3), "pass the " + named.words);
    }
    wrong((ambiguous ? "more than one: " : "not passed: ") + named.words);
    return false;
  }
  void between(const Claim& c) {
    const double before = now_;
    const std::size_t faults = faults_.size();
    for (const auto& [a, b] :
         {std::pair{Side::kLeft, Side::kRight}, std::pair{Side::kRight, Side::kLeft}}) {
      for (const bool first : {true, false}) {
        faults_.resize(faults);
        now_ = before;
        const bool ok =
            first ? pass(c.thing, a) && pass(c.second, b) : pass(c.second, b) && pass(c.thing, a);
        if (ok) return;
      }
    }
  }
  void over(const Claim& c) {
    for (auto i = static_cast<std::size_t>(now_ + 1e-9); i < legs(); ++i) {
      for (const std::size_t thing : c.thing.fits) {
        if (!is_the_one(c.thing, i, thing)) continue;
        for (double s = 0; s <= 1; s += 0.02) {
          const double when = static_cast<double>(i) + s;
          if (gap_to(home_->things[thing], at(when)) > 0) continue;
          const auto m = passed(thing, i, Side::kNone);
          if (!m || *m < now_ - kOrder) break;
          go_to(*m, "over the " + c.thing.words);
          return;
        }
      }
    }
    wrong("not walked over: " + c.thing.words);
  }
  void towards(const Claim& c) {
    for (auto i = static_cast<std::size_t>(std::ceil(now_ - 1e-9)); i < legs(); ++i) {
      const auto thing = the_one(c.thing, i);
      if (!thing || std::abs(bearing(i, headings_[i], home_->things[*thing])) > 20) continue;
      if (go_to(static_cast<double>(i) + 1e-3, "towards the " + c.thing.words)) return;
      return;
    }
    wrong("not ahead: " + c.thing.words);
  }

  void stands(const Claim& c) {
    const std::size_t i = c.at_start ? 0 : legs();
    const double facing = c.at_start ? start_heading_ : headings_.back();
    const auto thing = the_one(c.thing, i);
    if (!thing) return wrong("not in view, or more than one: " + c.thing.words);
    const double b = bearing(i, facing, home_->things[*thing]);
    const bool right = c.side == Side::kRight;
    const bool ok = c.kind == Kind::kAhead ? std::abs(b) < 45
                    : c.kind == Kind::kBehind
                        ? std::abs(b) > 150
                        : std::abs(b) > 40 && std::abs(b) < 140 && (b > 0) == right;
    if (!ok) wrong(fmt::format("{} is at {:.0f} degrees", c.thing.words, b));
  }
  void near(const Claim& c) {
    const auto thing = the_one(c.thing, legs());
    if (!thing) return wrong("not in view, or more than one: " + c.thing.words);
    const HomeThing& t = home_->things[*thing];
    if (gap_to(t, eyes_.back()) > 1.8) wrong("too far: " + c.thing.words);
    if (c.side == Side::kNone) return;
    const double b = bearing(legs(), headings_.back(), t);
    if (std::abs(b) < 40 || std::abs(b) > 140 || (b > 0) != (c.side == Side::kRight)) {
      wrong(fmt::format("{} is at {:.0f} degrees", c.thing.words, b));
    }
  }
  void by_door(const Claim& c) {
    unsigned close = 0;
    bool ok = false;
    const std::size_t here = room(at(end()));
    for (const Opening& o : home_->plan.openings) {
      const bool ours = o.room0 == here || o.room1 == here;
      const double far = gap_to(o, eyes_.back());
      if (o.kind == OpeningKind::kWindow || !ours || far > 1.4) continue;
      ++close;
      const bool named =
          (!c.to || c.to->contains(o.room0) || (o.room1 && c.to->contains(*o.room1))) &&
          (!c.from || c.from->contains(o.room0) || (o.room1 && c.from->contains(*o.room1)));
      ok = ok || (named && (!c.opening || o.kind == *c.opening) &&
                  (c.kind == Kind::kByDoor || far < 0.5));
    }
    if (!ok) wrong("no such door at the end");
    if (close > 1 && c.kind == Kind::kByDoor) wrong("more than one door at the end");
  }
  void in_middle(const Claim& c) {
    const std::size_t i = room(at(end()));
    const Rect& r = home_->plan.rooms[i].floor;
    const Point p = eyes_.back();
    if (!c.to->contains(i) || std::abs(p.x - (r.x0 + r.x1) / 2) > r.width() / 5 ||
        std::abs(p.y - (r.y0 + r.y1) / 2) > r.depth() / 5) {
      wrong("not in the middle of that room");
    }
  }
  void on_stairs() {
    if (on_storey(legs(), kThere)) wrong("not on the stairs");
  }

  // Metres to somewhere before the next turn, from the viewpoint before or after.
  void distance(const Claim& c) {
    double best = 1e9, most = 0;
    for (const double from : {std::floor(now_ + 1e-9), std::ceil(now_ - 1e-9)}) {
      double sum = 0;
      for (auto k = static_cast<std::size_t>(from); k < legs(); ++k) {
        if (k > static_cast<std::size_t>(from) && std::abs(turns_[k]) > 30) break;
        sum += std::hypot(eyes_[k + 1].x - eyes_[k].x, eyes_[k + 1].y - eyes_[k].y);
        best = std::min(best, std::abs(sum - c.metres));
        most = std::max(most, sum);
      }
    }
    if (best > 1 && !(c.metres > 12 && most > 12)) wrong("not that far");
  }

  void stop() {
    if (stopped_) return;
    stopped_ = true;
    if (!nothing_skipped(end())) wrong("stop: a turn before it is not said");
    // Another sort of room than the last that was said must not be entered in silence.
    for (const Passage& p : passages_) {
      const PlanRoom &a = home_->plan.rooms[p.from], &b = home_->plan.rooms[p.to];
      const bool at_door = metres(p.left, end()) < 1;  // what follows says where one stops
      if (!p.slight && !at_door && p.left > now_ + 1e-9 && a.type != b.type && b.type != 's' &&
          a.type != 's') {
        wrong("stop: goes on into the " + b.name);
      }
    }
    now_ = end();
  }

  std::vector<bool> turned_ = std::vector<bool>(legs());  // by a claim
  double now_ = 0, last_passage_ = -1;
  bool stopped_ = false;
  std::vector<std::string> faults_;
};

}  // namespace

std::vector<std::string> InstructionChecker::check(const std::string& text,
                                                   std::span<const ViewpointIndex> path,
                                                   double heading) const {
  return Walk(home_, tracer_, graph_, surfaces_, path, heading)
      .follow(read_instruction(home_, text));
}

}  // namespace enfilade::homes::instructions::testing
