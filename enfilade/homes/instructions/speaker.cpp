#include "enfilade/homes/instructions/speaker.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/homes/instructions/path_story.h"
#include "enfilade/homes/instructions/wording.h"

namespace enfilade::homes::instructions {
namespace {

// Degrees. A turn of kMustBeSaid or more is mentioned; smaller ones are left out until the turns
// since the last one that was mentioned add up to kMostUnsaid.
constexpr double kMustBeSaid = 38, kMostUnsaid = 50;

// What a clause ends with; the beginning of the next sentence may refer to it.
enum class After : std::uint8_t { kAnything, kRoom, kStairsTop, kStairsBottom, kTurn };

struct Clause {
  std::string text;
  After after = After::kAnything;
  std::optional<std::size_t> room;  // entered by it
  std::size_t place = 0;            // on the path, where it has been followed
};

// The number of words, plus a penalty for consecutive clauses that begin alike.
std::size_t cost_of(const std::string& text) {
  constexpr std::size_t kAlike = 5;
  std::size_t cost = 0, alike = 0;
  std::string before, opening, word;
  std::size_t place = 0;  // of the word in its clause
  std::istringstream in(text);
  while (in >> word) {
    ++cost;
    const bool ends = word.ends_with(',') || word.ends_with('.');
    if (ends) word.pop_back();
    word.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(word.front())));
    const bool links = word == "and" || word == "then";
    if (!links && place < 2) opening += word + " ";
    if (!links && ++place == 2 && opening == before) ++alike;
    if (!ends && !links) continue;
    if (place > 0) before = opening;
    opening.clear();
    place = 0;
  }
  return cost + kAlike * alike;
}

class Describer {
 public:
  Describer(const SpokenHome& home, const PathStory& story, std::span<const ViewpointIndex> path,
            SpeakerKind speaker, const Habits& habits, std::uint64_t seed)
      : story_(story),
        path_(path),
        speaker_(speaker),
        habits_(habits),
        words_(home, speaker, habits.brevity, seed),
        end_room_(story_.end.room) {
    for (const ViewpointIndex v : path) eyes_.push_back(to_double(home.graph.position(v)));
  }

  Spoken spoken() {
    words_.set_goal_room(end_room_);
    words_.been_in(story_.start.room);
    choose_goal();
    const std::string lead = start();
    for (std::size_t i = 0; i < story_.stretches.size(); ++i) {
      story_.stretches[i].climb != 0 ? climb(i) : walk(i);
      for (const Happening& h : story_.stretches[i].happenings) {
        if (h.kind == HappeningKind::kCross) words_.been_in(h.to);
      }
    }
    reached_ = path_.size() - 1;
    add(stop());
    Spoken result{compose(lead), {}};
    result.parts = parts_of(result.text);
    return result;
  }

 private:
  // Whether a turn is mentioned. A slight bend may be left out if a room is entered right after it
  // or if it cannot be mistaken for the next turn; other small bends are left out until they add
  // up.
  bool says_turn(std::size_t i, bool enters) {
    const PathStretch& s = story_.stretches[i];
    if (turn_of(s.turn) == TurnKind::kSlight && (enters || !is_mistakable(i)) &&
        words_.chance(habits_.bend)) {
      unsaid_ = 0;
      return false;
    }
    unsaid_ += s.turn;
    const bool large = std::abs(s.turn) >= kMustBeSaid || std::abs(unsaid_) >= kMostUnsaid;
    if (turn_of(s.turn) == TurnKind::kStraight || !large) return false;
    unsaid_ = 0;
    return true;
  }
  // Whether the next real turn is to the same side.
  bool is_mistakable(std::size_t i) const {
    for (std::size_t k = i + 1; k < story_.stretches.size(); ++k) {
      const double next = story_.stretches[k].turn;
      if (turn_of(next) == TurnKind::kFull) return next * story_.stretches[i].turn > 0;
    }
    return false;
  }
  void add(std::string text, After after = After::kAnything,
           std::optional<std::size_t> room = std::nullopt) {
    clauses_.push_back({std::move(text), after, room, reached_});
  }

  // The first viewpoint of a stretch that is `metres` along it.
  std::size_t place_at(const PathStretch& s, double metres) const {
    std::size_t place = s.first;
    for (double walked = 0; place < s.last && walked < metres - 0.05; ++place) {
      walked +=
          std::hypot(eyes_[place + 1].x - eyes_[place].x, eyes_[place + 1].y - eyes_[place].y);
    }
    return place;
  }

  // Cuts the text behind each clause, and behind the comma or full stop that follows it.
  std::vector<SpokenPart> parts_of(const std::string& text) const {
    std::vector<SpokenPart> parts;
    std::size_t begin = 0, first = 0;
    for (const Clause& clause : clauses_) {
      const bool is_last = &clause == &clauses_.back();
      // A sentence has made its first letter a capital.
      const std::size_t found = text.find(clause.text.substr(1), begin);
      EN_CHECK(found != std::string::npos);
      std::size_t end = is_last ? text.size() : found + clause.text.size() - 1;
      if (end < text.size() && (text[end] == ',' || text[end] == '.')) ++end;
      const std::size_t last = std::max(first, is_last ? path_.size() - 1 : clause.place);
      parts.push_back({text.substr(begin, end - begin), first, last});
      begin = std::min(text.find_first_not_of(' ', end), text.size());
      first = last;
    }
    return parts;
  }

  std::string start() {
    if (!words_.chance(habits_.start)) return "";
    for (const Neighbour& n : story_.start.around) {
      const auto name = words_.thing(n.thing, path_.front(), Rivals::kNearby);
      if (!name) continue;
      if (auto lead = words_.at_start(*name, n.bearing)) {
        mentioned_.insert(n.thing);
        return *lead;
      }
    }
    return "";
  }

  // Chooses the thing to stop by; other clauses then leave it out.
  void choose_goal() {
    if (!words_.chance(habits_.goal)) return;
    const std::vector<Neighbour>& near = story_.end.near;
    for (std::size_t k = 0; k < near.size() && k < kGoals; ++k) {
      const auto name = words_.thing(near[k].thing, path_.back(), Rivals::kHere);
      if (!name || (k + 1 < near.size() && words_.chance(0.2))) continue;
      goal_ = near[k];
      names_[goal_->thing] = *name;
      mentioned_.insert(goal_->thing);
      return;
    }
  }

  void climb(std::size_t i) {
    const PathStretch& s = story_.stretches[i];
    const bool turns = says_turn(i, false);
    const std::string stairs = words_.stairs(s);  // drawn before the words of the turn
    reached_ = s.last;
    add(turns ? words_.turn(s.turn) + " and " + stairs : stairs, stairs_after(s));
    for (const Happening& h : s.happenings) {
      if (h.kind == HappeningKind::kCross && !words_.naming().is_stairs(h.to)) {
        add(words_.into(h), After::kRoom, h.to);
      }
    }
  }

  static After stairs_after(const PathStretch& s) {
    if (!s.to_storey) return After::kAnything;
    return s.climb > 0 ? After::kStairsTop : After::kStairsBottom;
  }

  // Entering a stairwell is not mentioned where the path goes on by the stairs.
  bool is_spoken(const Happening& h, std::size_t stretch) const {
    if (h.kind != HappeningKind::kCross) return false;
    const bool last = stretch + 1 == story_.stretches.size();
    if (words_.naming().is_stairs(h.to)) {
      return last ? story_.end.stairs == 0 && !story_.end.on_stairs
                  : story_.stretches[stretch + 1].climb == 0;
    }
    return h.opening.has_value() || !words_.naming().same_room_name(h.from, h.to);
  }

  // A crossing from one hall into another may be left out, unless it is the last one or the last
  // one enters another room of that name.
  bool may_skip(const Happening& h) const {
    if (h.kind != HappeningKind::kCross) return false;
    const Naming& names = words_.naming();
    const bool halls = names.is_way(h.to) && (names.is_way(h.from) || !clauses_.empty());
    const Happening* last = last_crossing();
    const bool is_last = last == nullptr || &h == last || names.same_room_name(h.to, last->to);
    return halls && !is_last;
  }
  const Happening* last_crossing() const {
    const Happening* last = nullptr;
    for (std::size_t i = 0; i < story_.stretches.size(); ++i) {
      for (const Happening& h : story_.stretches[i].happenings) {
        if (is_spoken(h, i)) last = &h;
      }
    }
    return last;
  }

  // The crossings and things of a stretch that are mentioned, in order.
  std::vector<Happening> chosen(std::size_t i) {
    const PathStretch& s = story_.stretches[i];
    std::vector<Happening> things, found;
    for (const Happening& h : s.happenings) {
      const bool skips = may_skip(h) && words_.chance(habits_.skip);
      if (is_spoken(h, i) && !skips) found.push_back(h);
      if (h.kind != HappeningKind::kCross && !mentioned_.contains(h.thing)) things.push_back(h);
    }
    std::ranges::stable_sort(things, std::ranges::greater(), &Happening::salience);
    if (things.size() > 1 && words_.chance(0.3)) std::swap(things[0], things[1]);
    for (const Happening& h : things) {
      if (things_said_ >= habits_.all_things) break;
      if (mentioned_.contains(h.thing) || !words_.chance(habits_.things)) continue;
      const auto name = words_.thing(h.thing, h.seen_from, Rivals::kNearby);
      if (!name) continue;
      mentioned_.insert(h.thing);
      names_[h.thing] = *name;
      found.push_back(h);
      ++things_said_;
      break;  // one a stretch
    }
    std::ranges::stable_sort(found, {}, &Happening::metres);
    return found;
  }

  void walk(std::size_t i) {
    const PathStretch& s = story_.stretches[i];
    const std::vector<Happening> all = chosen(i);
    const bool enters =
        !all.empty() && all[0].kind == HappeningKind::kCross && in_first_leg(s, all[0]);
    const bool turns = says_turn(i, enters);
    std::size_t next = 0;
    reached_ = s.first;
    if (turns && enters) {
      reached_ = place_at(s, all[0].metres);
      add(words_.turn_and_cross(s, all[0]), After::kRoom, all[0].to);
      join_turns(s);
      next = 1;
    } else if (turns && all.empty() && is_hall(s) && turn_of(s.turn) == TurnKind::kFull &&
               words_.chance(habits_.distance)) {
      reached_ = s.last;
      add(words_.along(s, true));
      return;
    } else if (turns) {
      add(words_.turn(s.turn), After::kTurn);
      join_turns(s);
    }
    if (next == 0) {
      // What is ahead leads to where something happens.
      reached_ = all.empty() ? s.last : std::max(s.first, place_at(s, all[0].metres - 1));
      go_on(i, all, turns);
    }
    const bool straight = turn_of(s.turn) == TurnKind::kStraight;
    for (; next < all.size(); ++next) {
      reached_ = place_at(s, all[next].metres);
      if (add_pair(all, next, straight)) {
        ++next;
        clauses_.back().place = place_at(s, all[next].metres);
      } else {
        add_one(all[next], straight && next == 0 && enters);
      }
    }
  }

  // "Turn left, then right into the kitchen": two turns in a row need one verb.
  void join_turns(const PathStretch& s) {
    if (clauses_.size() < 2 || turn_of(s.turn) != TurnKind::kFull) return;
    const Clause& last = clauses_.back();
    Clause& before = clauses_[clauses_.size() - 2];
    const std::string side = s.turn > 0 ? "right" : "left";
    if ((before.text != "turn left" && before.text != "turn right" && before.text != "go left" &&
         before.text != "go right") ||
        !words_.chance(habits_.elide)) {
      return;
    }
    for (const char* verb : {"turn ", "go "}) {
      if (!last.text.starts_with(verb + side)) continue;
      const std::string rest = last.text.substr((verb + side).size());
      const bool again = before.text.ends_with(side);
      Clause joined = last;
      joined.text = before.text + (words_.chance(0.5) ? ", then " : " and then ") + side +
                    (again ? " again" : "") + rest;
      clauses_.resize(clauses_.size() - 2);
      clauses_.push_back(std::move(joined));
      return;
    }
  }

  bool is_hall(const PathStretch& s) const {
    return s.room == s.room_after && words_.naming().is_way(s.room) &&
           !words_.naming().is_stairs(s.room) && s.metres > 2.2;
  }

  // Adds a clause for the way ahead, before anything happens on it.
  void go_on(std::size_t i, const std::vector<Happening>& all, bool turns) {
    const PathStretch& s = story_.stretches[i];
    if (s.metres >= 1.5 && things_said_ < habits_.all_things && words_.chance(habits_.towards)) {
      for (const std::size_t thing : s.ahead) {
        if (mentioned_.contains(thing)) continue;
        const auto name = words_.thing(thing, path_[s.first], Rivals::kNearby);
        if (!name) continue;
        mentioned_.insert(thing);
        ++things_said_;
        add(words_.towards(*name));
        return;
      }
    }
    if (!all.empty()) return;
    if (is_hall(s) && words_.chance(habits_.distance)) {
      add(words_.along(s, false));
    } else if ((turns || (i == 0 && turn_of(s.turn) == TurnKind::kStraight)) && s.metres > 1 &&
               words_.chance(habits_.distance / 2)) {
      add(words_.walk(s.metres));
    } else if (turn_of(s.turn) == TurnKind::kStraight && i == 0) {
      add(words_.straight());
    }
  }

  static bool in_first_leg(const PathStretch& s, const Happening& crossing) {
    return crossing.metres < std::min(kSameBreath, s.first_leg);
  }

  // Adds one clause for two happenings: things at both sides, or a room that is only passed
  // through. False if these two do not go together.
  bool add_pair(const std::vector<Happening>& all, std::size_t k, bool straight) {
    if (k + 1 >= all.size()) return false;
    const Happening &a = all[k], &b = all[k + 1];
    if (a.kind == HappeningKind::kPass && b.kind == HappeningKind::kPass &&
        a.on_right != b.on_right && a.seen_from == b.seen_from &&
        std::abs(a.metres - b.metres) < 0.6) {
      add(words_.between(names_[a.thing], names_[b.thing]));
      return true;
    }
    const bool rooms = a.kind == HappeningKind::kCross && b.kind == HappeningKind::kCross;
    if (!rooms || words_.naming().same_room_name(a.to, b.to) ||
        words_.naming().same_room_name(a.from, a.to) || !words_.chance(habits_.merge)) {
      return false;
    }
    if (speaker_ == SpeakerKind::kTerse && words_.chance(0.5)) {
      add(words_.into(b), After::kRoom, b.to);
    } else {
      add(words_.through(a, b, straight), After::kRoom, b.to);
    }
    return true;
  }

  void add_one(const Happening& h, bool straight) {
    if (h.kind == HappeningKind::kCross) {
      add(words_.cross(h, straight), After::kRoom, h.to);
    } else if (h.kind == HappeningKind::kPass) {
      add(words_.pass(names_[h.thing], h.on_right));
    } else {
      add(words_.over(names_[h.thing]));
    }
  }

  std::string stop() {
    const PathEnd& e = story_.end;
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
    if (fresh && words_.naming().is_way(e.room)) {
      // "Leave the kitchen" has not mentioned the hallway yet.
      return clauses_.back().text.ends_with(words_.room(e.room))
                 ? words_.say("[stop|wait] there")
                 : words_.stop(words_.say("in the $room", room));
    }
    if (e.just_inside && fresh) {
      return words_.say(
          "[stop|wait|stop|wait|halt] [just|right] inside|stop once you are inside|"
          "[stop|wait] [inside|there]|[stop|wait|stand] just inside the $room",
          room);
    }
    if (e.in_middle)
      return words_.stop(words_.say("in the [middle|center|centre] of the $room", room));
    if (words_.naming().is_stairs(e.room)) return words_.stop("by the stairs");
    return fresh ? words_.say("[stop|wait] [there|inside]")
                 : words_.stop(words_.say("in the $room", room));
  }

  // Joins the clauses into sentences.
  std::string compose(const std::string& lead) {
    std::string text;
    for (std::size_t i = 0; i < clauses_.size();) {
      const std::size_t n = sentence_length(i);
      std::vector<std::string> parts;
      for (std::size_t k = i; k < i + n; ++k) parts.push_back(clauses_[k].text);
      std::string one = join_clauses(parts, habits_.links, words_.rng());
      if (i == 0 && !lead.empty()) {
        one = lead + ", " + one;
      } else if (i == 0 && n < clauses_.size() && words_.chance(habits_.openings / 3)) {
        one = words_.say("[first,|to start,|to begin,]") + " " + one;
      } else if (i > 0 && !stands_alone(clauses_[i]) && one.find("then ") == std::string::npos) {
        one = opening(clauses_[i - 1], i + n == clauses_.size()) + one;
      }
      text += (text.empty() ? "" : " ") + sentence(one);
      i += n;
    }
    return text;
  }

  // "You will see ..." is no imperative, so it is not joined with other clauses.
  static bool stands_alone(const Clause& clause) { return clause.text.starts_with("you "); }
  // The number of clauses of the sentence that begins with clause i.
  std::size_t sentence_length(std::size_t i) {
    const std::size_t left = clauses_.size() - i;
    std::size_t n = std::min<std::size_t>(left, 1 + words_.rng().below(habits_.clauses));
    if (left == n + 1 && words_.chance(habits_.brevity))
      n = left;  // avoids a last sentence of one clause
    for (std::size_t k = 0; k < n; ++k) {
      if (stands_alone(clauses_[i + k])) return std::max<std::size_t>(k, 1);
    }
    return n;
  }

  // Words that may connect a sentence to the one before it.
  std::string opening(const Clause& before, bool last) {
    if (!words_.chance(habits_.openings)) return "";
    std::string_view pattern = "[then|next,|after that,|from there,|now|from here,|afterwards,]";
    Slots slots;
    if (last) {
      pattern = "[finally,|then|lastly,]";
    } else if (before.after == After::kStairsTop && words_.chance(0.6)) {
      pattern = "[at the top,|once you are upstairs,|at the top of the stairs,]";
    } else if (before.after == After::kStairsBottom && words_.chance(0.6)) {
      pattern = "[at the bottom,|once you are downstairs,|at the foot of the stairs,]";
    } else if (before.after == After::kRoom && words_.chance(0.5)) {
      pattern = words_.naming().is_way(*before.room)
                    ? "[in the $room,|when you are in the $room,|once you are in the $room,]"
                    : "[once inside,|in the $room,|when you are in the $room,|inside,]";
      slots = {{"room", words_.room(*before.room)}};
    }
    return words_.say(pattern, slots) + " ";
  }

  // How many of the things near the path's end are tried as the one to stop by.
  static constexpr std::size_t kGoals = 4;
  // Metres walked after a turn. A room entered sooner is mentioned in the turn's clause.
  static constexpr double kSameBreath = 2.5;

  const PathStory& story_;
  std::span<const ViewpointIndex> path_;
  SpeakerKind speaker_;
  Habits habits_;
  Wording words_;
  std::size_t end_room_;
  std::vector<Clause> clauses_;
  std::set<std::size_t> mentioned_;
  std::map<std::size_t, std::string> names_;
  std::optional<Neighbour> goal_;
  std::size_t things_said_ = 0;
  std::size_t reached_ = 0;  // place on the path that the next clause leads to
  std::vector<Vec3d> eyes_;  // of the path
  double unsaid_ = 0;        // sum of turns, degrees, since the last turn that was said
};

}  // namespace

Spoken describe(const SpokenHome& home, std::span<const ViewpointIndex> viewpoints, double heading,
                SpeakerKind speaker, std::uint64_t seed) {
  constexpr int kTries = 10;
  const PathStory story = tell_path(home, viewpoints, heading);
  const Habits habits = habits_of(speaker);
  Rng rng(seed, static_cast<std::uint64_t>(speaker));
  const std::size_t words =
      habits.least_words + rng.below(habits.most_words - habits.least_words + 1);
  Spoken best;
  std::size_t least = 0;
  for (int k = 0; k < kTries && (best.text.empty() || least > words); ++k) {
    const Habits lean = leaner_habits(habits, static_cast<double>(k) / (kTries - 1));
    Spoken spoken = Describer(home, story, viewpoints, speaker, lean, rng.next()).spoken();
    const std::size_t cost = cost_of(spoken.text);
    if (!best.text.empty() && cost >= least) continue;
    least = cost;
    best = std::move(spoken);
  }
  return best;
}

}  // namespace enfilade::homes::instructions
