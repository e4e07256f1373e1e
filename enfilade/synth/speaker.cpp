#include "enfilade/synth/speaker.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "enfilade/synth/detail/wording.h"

namespace enfilade::synth {
namespace {

using detail::Happening;
using detail::Neighbour;
using detail::PathStory;
using detail::Slots;
using detail::Stretch;
using detail::Turn;
using detail::turn_of;
using detail::Wording;

// What the three kinds of people say and leave out.
struct Habits {
  double least_turn;        // degrees: smaller ones are not spoken of
  double start;             // how often they begin with what is around them
  double towards;           // how often they name what they head for
  double things;            // how often they name a thing that is passed
  std::size_t most_things;  // in a stretch
  double distance;          // how often they say how far
  double merge;             // how often two rooms make one clause
  double skip;              // how often they say nothing of a hall that they come into
  std::size_t clauses;      // in a sentence, at most
  std::size_t all_things;   // in an instruction, those at its ends not counted
  double openings;          // how often a sentence begins with "then" and the like
};

// Degrees: a bend that somebody who looks for "turn left" could take for it.
constexpr double kMustBeSaid = 38, kMostUnsaid = 50;

const Habits& habits_of(Speaker speaker) {
  static const Habits kTerse{kMustBeSaid, 0, 0.05, 0.02, 1, 0, 0.8, 0.85, 3, 1, 0};
  static const Habits kLandmarks{kMustBeSaid, 0.2, 0.2, 0.4, 1, 0, 0.7, 0.85, 2, 2, 0.12};
  static const Habits kStepByStep{30, 0.1, 0.06, 0.12, 1, 0.2, 0.3, 0.4, 2, 1, 0.25};
  switch (speaker) {
    case Speaker::kTerse:
      return kTerse;
    case Speaker::kLandmarks:
      return kLandmarks;
    case Speaker::kStepByStep:
      break;
  }
  return kStepByStep;
}

// What a clause leaves the reader with, for how the next may begin.
enum class After : std::uint8_t { kAnything, kRoom, kStairsTop, kStairsBottom, kTurn };

struct Clause {
  std::string text;
  After after = After::kAnything;
  std::optional<std::size_t> room;  // entered by it
};

class Describer {
 public:
  Describer(const SpokenHome& home, std::span<const ViewpointIndex> path, double heading,
            Speaker speaker, std::uint64_t seed)
      : story_(detail::tell_path(home, path, heading)),
        path_(path),
        speaker_(speaker),
        habits_(habits_of(speaker)),
        words_(home, speaker, seed),
        end_room_(story_.end.room) {}

  std::string text() {
    choose_goal();
    const std::string lead = start();
    for (std::size_t i = 0; i < story_.stretches.size(); ++i) {
      story_.stretches[i].climb != 0 ? climb(i) : walk(i);
    }
    clauses_.push_back({stop(), After::kAnything, std::nullopt});
    return compose(lead);
  }

 private:
  // Small bends need not be said, unless they add up.
  bool says_turn(const Stretch& s) {
    unsaid_ += s.turn;
    const bool large = std::abs(s.turn) >= habits_.least_turn || std::abs(unsaid_) >= kMostUnsaid;
    if (turn_of(s.turn) == Turn::kStraight || !large) return false;
    unsaid_ = 0;
    return true;
  }
  void add(std::string text, After after = After::kAnything,
           std::optional<std::size_t> room = std::nullopt) {
    clauses_.push_back({std::move(text), after, room});
  }

  std::string start() {
    if (!words_.chance(habits_.start)) return "";
    for (const Neighbour& n : story_.start.around) {
      const auto name = words_.thing(n.thing, path_.front());
      if (!name) continue;
      if (auto lead = words_.at_start(*name, n.bearing)) {
        mentioned_.insert(n.thing);
        return *lead;
      }
    }
    return "";
  }

  // The thing to stop by, which is then kept for the end.
  void choose_goal() {
    if (!words_.chance(speaker_ == Speaker::kTerse ? 0.6 : 0.9)) return;
    const std::vector<Neighbour>& near = story_.end.near;
    for (std::size_t k = 0; k < near.size() && k < kGoals; ++k) {
      const auto name = words_.thing(near[k].thing, path_.back());
      if (!name) continue;
      goal_ = near[k];
      names_[goal_->thing] = *name;
      mentioned_.insert(goal_->thing);
      return;
    }
  }

  void climb(std::size_t i) {
    const Stretch& s = story_.stretches[i];
    if (says_turn(s)) {
      add(words_.turn(s.turn) + " and " + words_.stairs(s), stairs_after(s));
    } else {
      add(words_.stairs(s), stairs_after(s));
    }
    for (const Happening& h : s.happenings) {
      if (h.kind == Happening::Kind::kCross && !words_.naming().is_stairs(h.to)) {
        add(words_.into(h), After::kRoom, h.to);
      }
    }
  }

  static After stairs_after(const Stretch& s) {
    if (!s.to_storey) return After::kAnything;
    return s.climb > 0 ? After::kStairsTop : After::kStairsBottom;
  }

  // Stairwells are not rooms to people: they go up the stairs.
  bool is_spoken(const Happening& h, std::size_t stretch) const {
    if (h.kind != Happening::Kind::kCross) return false;
    const bool last = stretch + 1 == story_.stretches.size();
    if (words_.naming().is_stairs(h.to)) {
      return last ? story_.end.stairs == 0 && !story_.end.on_stairs
                  : story_.stretches[stretch + 1].climb == 0;
    }
    return h.opening.has_value() || !words_.naming().same_room_name(h.from, h.to);
  }

  // From one hall into another: nothing that one needs to be told, but at the end.
  bool may_skip(const Happening& h) const {
    const detail::Naming& names = words_.naming();
    const bool halls = names.is_way(h.to) && (names.is_way(h.from) || !clauses_.empty());
    return h.kind == Happening::Kind::kCross && halls && &h != last_crossing();
  }
  const Happening* last_crossing() const {
    const Happening* last = nullptr;
    for (const Stretch& s : story_.stretches) {
      for (const Happening& h : s.happenings) {
        if (h.kind == Happening::Kind::kCross) last = &h;
      }
    }
    return last;
  }

  // Crossings, and some of the things, of a stretch.
  std::vector<Happening> chosen(std::size_t i, bool turns) {
    const Stretch& s = story_.stretches[i];
    const auto first = std::ranges::find(s.happenings, Happening::Kind::kCross, &Happening::kind);
    std::vector<Happening> things, found;
    for (const Happening& h : s.happenings) {
      // What one turns to is said.
      const bool skips = may_skip(h) && !(turns && &h == &*first) && words_.chance(habits_.skip);
      if (is_spoken(h, i) && !skips) found.push_back(h);
      if (h.kind != Happening::Kind::kCross && !mentioned_.contains(h.thing)) things.push_back(h);
    }
    std::ranges::stable_sort(things, std::ranges::greater(), &Happening::salience);
    std::size_t said = 0;
    for (const Happening& h : things) {
      if (said == habits_.most_things || things_said_ >= habits_.all_things) break;
      if (mentioned_.contains(h.thing) || !words_.chance(habits_.things)) continue;
      const auto name = words_.thing(h.thing, h.seen_from);
      if (!name) continue;
      mentioned_.insert(h.thing);
      names_[h.thing] = *name;
      found.push_back(h);
      ++said;
      ++things_said_;
    }
    std::ranges::stable_sort(found, {}, &Happening::metres);
    return found;
  }

  void walk(std::size_t i) {
    const Stretch& s = story_.stretches[i];
    const bool turns = says_turn(s);
    const std::vector<Happening> all = chosen(i, turns);
    std::size_t next = 0;
    const bool crosses_first = !all.empty() && all[0].kind == Happening::Kind::kCross;
    if (turns) {
      if (crosses_first && in_first_leg(s, all[0])) {
        add(words_.turn_and_cross(s, all[0]), After::kRoom, all[0].to);
        next = 1;
      } else if (all.empty() && is_hall(s) && turn_of(s.turn) == Turn::kFull &&
                 words_.chance(0.6)) {
        add(words_.along(s, true));
        return;
      } else {
        add(words_.turn(s.turn), After::kTurn);
      }
    }
    if (next == 0) go_on(i, all, turns);
    for (; next < all.size(); ++next) {
      if (add_pair(all, next))
        ++next;
      else
        add_one(all[next]);
    }
  }

  bool is_hall(const Stretch& s) const {
    return s.room == s.room_after && words_.naming().is_way(s.room) &&
           !words_.naming().is_stairs(s.room) && s.metres > 2.2;
  }

  // The way ahead, before anything happens on it.
  void go_on(std::size_t i, const std::vector<Happening>& all, bool turns) {
    const Stretch& s = story_.stretches[i];
    if (s.metres >= 1.5 && things_said_ < habits_.all_things && words_.chance(habits_.towards)) {
      for (const std::size_t thing : s.ahead) {
        if (mentioned_.contains(thing)) continue;
        const auto name = words_.thing(thing, path_[s.first]);
        if (!name) continue;
        mentioned_.insert(thing);
        ++things_said_;
        add(words_.towards(*name));
        return;
      }
    }
    if (!all.empty()) return;
    if (is_hall(s) && words_.chance(0.6)) {
      add(words_.along(s, false));
    } else if ((turns || i == 0) && s.metres > 1 && words_.chance(habits_.distance)) {
      add(words_.walk(s.metres));
    } else if (turn_of(s.turn) == Turn::kStraight && i == 0) {
      add(words_.straight());
    }
  }

  static bool in_first_leg(const Stretch& s, const Happening& crossing) {
    return crossing.metres < std::min(kSameBreath, s.first_leg);
  }

  // Two things on either side, or a room that is only passed through.
  bool add_pair(const std::vector<Happening>& all, std::size_t k) {
    if (k + 1 >= all.size()) return false;
    const Happening &a = all[k], &b = all[k + 1];
    if (a.kind == Happening::Kind::kPass && b.kind == Happening::Kind::kPass &&
        a.on_right != b.on_right && a.seen_from == b.seen_from &&
        std::abs(a.metres - b.metres) < 0.6) {
      add(words_.between(names_[a.thing], names_[b.thing]));
      return true;
    }
    const bool rooms = a.kind == Happening::Kind::kCross && b.kind == Happening::Kind::kCross;
    if (!rooms || words_.naming().same_room_name(a.to, b.to) ||
        words_.naming().same_room_name(a.from, a.to) || !words_.chance(habits_.merge)) {
      return false;
    }
    add(words_.through(a, b), After::kRoom, b.to);
    return true;
  }

  void add_one(const Happening& h) {
    switch (h.kind) {
      case Happening::Kind::kCross:
        add(words_.cross(h), After::kRoom, h.to);
        break;
      case Happening::Kind::kPass:
        add(words_.pass(names_[h.thing], h.on_right));
        break;
      case Happening::Kind::kOver:
        add(words_.over(names_[h.thing]));
        break;
    }
  }

  std::string stop() {
    const detail::PathEnd& e = story_.end;
    Slots room{{"room", words_.room(end_room_)}};
    if (e.on_stairs) return words_.stop("on the stairs");
    if (e.in_opening) return words_.stop(words_.in_doorway(*e.in_opening));
    if (e.stairs != 0) {
      return words_.stop(
          words_.say(e.stairs > 0 ? "at the [top|very top|head] of the [stairs|staircase|steps]"
                                  : "at the [bottom|foot] of the [stairs|staircase|steps]"));
    }
    if (goal_) return words_.stop(words_.beside(names_[goal_->thing], *goal_));
    if (e.near_opening && words_.chance(0.8)) {
      return words_.stop(words_.by_door(*e.near_opening, e.room));
    }
    const bool fresh = !clauses_.empty() && clauses_.back().room == e.room;
    if (e.at_end) return words_.stop(words_.say("at the end of the $room", room));
    if (e.just_inside && fresh && words_.chance(0.7)) {
      return words_.say(
          "[stop|wait|halt] [just|right] inside|stop [once|as soon as] you are inside|"
          "wait inside|stop there|wait there|stop as soon as you are in the $room",
          room);
    }
    if (e.in_middle)
      return words_.stop(words_.say("in the [middle|center|centre] of the $room", room));
    return words_.stop(
        words_.say(words_.naming().is_stairs(e.room) ? "by the stairs" : "in the $room", room));
  }

  // Clauses become sentences.
  std::string compose(const std::string& lead) {
    std::string text;
    for (std::size_t i = 0; i < clauses_.size();) {
      const std::size_t left = clauses_.size() - i;
      std::size_t n = std::min<std::size_t>(left, 1 + words_.rng().below(habits_.clauses));
      if (left == n + 1 && speaker_ == Speaker::kTerse) n = left;  // no lonely stop
      std::vector<std::string> parts;
      for (std::size_t k = i; k < i + n; ++k) parts.push_back(clauses_[k].text);
      std::string one = detail::join_clauses(parts, words_.rng());
      if (i == 0 && !lead.empty()) {
        one = lead + ", " + one;
      } else if (i > 0) {
        one = opening(clauses_[i - 1], i + n == clauses_.size()) + one;
      }
      text += (text.empty() ? "" : " ") + detail::sentence(one);
      i += n;
    }
    return text;
  }

  // How a sentence may follow another.
  std::string opening(const Clause& before, bool last) {
    if (!words_.chance(habits_.openings)) return "";
    if (last) return words_.say("[finally,|then|lastly,]") + " ";
    if (before.after == After::kStairsTop && words_.chance(0.6)) {
      return words_.say("[at the top,|once you are upstairs,|at the top of the stairs,]") + " ";
    }
    if (before.after == After::kStairsBottom && words_.chance(0.6)) {
      return words_.say("[at the bottom,|once you are downstairs,|at the foot of the stairs,]") +
             " ";
    }
    if (before.after == After::kRoom && words_.chance(0.5)) {
      return words_.say(
                 words_.naming().is_way(*before.room)
                     ? "[in the $room,|when you are in the $room,|once you are in the $room,]"
                     : "[once inside,|in the $room,|when you are in the $room,|inside,]",
                 {{"room", words_.room(*before.room)}}) +
             " ";
    }
    return words_.say("[then|next,|after that,|from there,|now|from here,|afterwards,]") + " ";
  }

  static constexpr std::size_t kGoals = 4;
  // Metres: a door that comes sooner after a turn is said in one breath with it.
  static constexpr double kSameBreath = 2.5;

  PathStory story_;
  std::span<const ViewpointIndex> path_;
  Speaker speaker_;
  const Habits& habits_;
  Wording words_;
  std::size_t end_room_;
  std::vector<Clause> clauses_;
  std::set<std::size_t> mentioned_;
  std::map<std::size_t, std::string> names_;
  std::optional<Neighbour> goal_;
  std::size_t things_said_ = 0;
  double unsaid_ = 0;  // degrees since the last turn that was said
};

}  // namespace

std::string describe(const SpokenHome& home, std::span<const ViewpointIndex> viewpoints,
                     double heading, Speaker speaker, std::uint64_t seed) {
  return Describer(home, viewpoints, heading, speaker, seed).text();
}

}  // namespace enfilade::synth
