#include "enfilade/homes/instructions/wording.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace enfilade::homes::instructions {
namespace {

std::string side_of(bool right) { return right ? "right" : "left"; }

constexpr std::array<std::string_view, 13> kNumbers{"zero", "one",    "two",   "three", "four",
                                                    "five", "six",    "seven", "eight", "nine",
                                                    "ten",  "eleven", "twelve"};
constexpr double kMetresPerFoot = 0.3048;
constexpr double kSharp = 105;  // degrees
constexpr std::array<std::string_view, 5> kOrdinals{"", "first", "second", "third", "fourth"};

// By SpeakerKind.
constexpr std::array<Habits, 4> kHabits{
    // kTerse
    Habits{.brevity = 1,
           .bend = 0.85,
           .towards = 0.02,
           .things = 0.02,
           .all_things = 1,
           .merge = 0.7,
           .skip = 0.9,
           .goal = 0.8,
           .elide = 0.8,
           .clauses = 4,
           .links = ClauseLinks::kShort,
           .least_words = 8,
           .most_words = 20},
    // kLandmarks
    Habits{.brevity = 0.6,
           .bend = 0.6,
           .start = 0.12,
           .towards = 0.2,
           .things = 0.7,
           .all_things = 2,
           .distance = 0.1,
           .merge = 0.7,
           .skip = 0.8,
           .openings = 0.08,
           .goal = 0.95,
           .elide = 0.4,
           .clauses = 3,
           .least_words = 20,
           .most_words = 40},
    // kStepByStep
    Habits{.brevity = 0.3,
           .bend = 0.25,
           .start = 0.06,
           .towards = 0.1,
           .things = 0.2,
           .all_things = 1,
           .distance = 0.4,
           .merge = 0.4,
           .skip = 0.6,
           .openings = 0.2,
           .goal = 0.9,
           .elide = 0.2,
           .clauses = 2,
           .least_words = 20,
           .most_words = 40},
    // kGuide: as long as the path asks for
    Habits{.brevity = 0.1,
           .bend = 0,
           .start = 0.9,
           .towards = 0.6,
           .things = 0.95,
           .all_things = 8,
           .distance = 0.8,
           .merge = 0,
           .skip = 0,
           .openings = 0.5,
           .goal = 1,
           .elide = 0,
           .clauses = 2,
           .least_words = 300,
           .most_words = 300},
};

}  // namespace

Habits habits_of(SpeakerKind speaker) { return kHabits.at(static_cast<std::size_t>(speaker)); }

Habits leaner_habits(Habits h, double leaner) {
  for (double* share : {&h.brevity, &h.bend, &h.merge, &h.skip, &h.elide}) {
    *share += (1 - *share) * leaner;
  }
  for (double* share : {&h.start, &h.towards, &h.distance, &h.openings}) *share *= 1 - leaner;
  h.things *= 1 - leaner / 2;  // landmarks say the most in few words
  return h;
}

std::string Wording::turn(double degrees) {
  const Slots slots{{"side", side_of(degrees > 0)}};
  if (turn_of(degrees) == TurnKind::kSlight) {
    return say(
        "[3*bear $side|2*veer $side|2*turn slightly $side|go slightly $side|take a slight $side|"
        "make a slight $side|angle $side|turn a bit $side|turn a little $side|curve $side|"
        "veer off to the $side|head slightly $side|turn slightly to the $side|turn gently $side]",
        slots);
  }
  if (turn_of(degrees) == TurnKind::kAround) {
    return say(
        "[7*turn around|turn all the way around|turn completely around|make a U-turn|spin around|"
        "turn to face the other way|reverse direction|[2*turn|spin] yourself around]");
  }
  if (std::abs(degrees) > kSharp && chance(0.2)) {
    return say("[[take|make] a [2*sharp|hard] $side|turn sharply $side|turn sharp $side]", slots);
  }
  if (speaker_ == SpeakerKind::kTerse) {
    return say("[4*turn $side|2*go $side|take a $side|[hang|hook] a $side]", slots);
  }
  if (brief()) {
    return say("[5*turn $side|go $side|2*take a $side|2*make a $side|hang a $side]", slots);
  }
  return say(
      "[4*turn $side|take a $side|make a $side|turn to the $side|turn to your $side|"
      "make a $side turn|take a $side turn|go to your $side|swing $side|rotate $side|pivot $side]",
      slots);
}

std::string Wording::straight() {
  return say(
      "[[go|walk|head|keep going|carry on|proceed|move] [2*straight|ahead|forward]|"
      "[go|walk|head] straight [ahead|on]|continue [straight|ahead|forward|onward]|"
      "keep [straight|walking straight]]");
}

std::string Wording::walk(double metres) {
  static const std::map<long, std::string> kFeet{
      {5, "five"}, {10, "ten"}, {15, "fifteen"}, {20, "twenty"}, {30, "thirty"}};
  const auto whole = static_cast<std::size_t>(std::lround(metres));
  const auto feet = kFeet.find(5 * std::lround(metres / kMetresPerFoot / 5));
  std::string how_far;
  if (feet != kFeet.end() && chance(0.3)) {
    how_far = say("[about|around|roughly] $n feet", {{"n", feet->second}});
  } else if (whole <= 2) {
    how_far = say("[a couple of [metres|meters|paces]|a short way|a little way]");
  } else if (whole <= 12) {
    const Slots number{{"n", std::string(kNumbers.at(whole))}};
    how_far = say("[about $n|roughly $n|some $n] [metres|meters]", number);
  } else {
    how_far = say("[a long way|quite a distance]");
  }
  return say("[walk|go|walk|move|advance|stride] [forward|straight|ahead|straight ahead] $far",
             {{"far", how_far}});
}

std::string Wording::along(const PathStretch& stretch, bool with_turn) {
  const Slots slots{{"room", room(stretch.room_after)}, {"side", side_of(stretch.turn > 0)}};
  if (with_turn) {
    return say("[2*turn|go|head] $side [down|along] the $room|take a $side down the $room", slots);
  }
  if (stretch.to_end) {
    return say(
        "[walk|go|continue|head] to the end of the $room|follow the $room to the end|"
        "[walk|go] all the way down the $room",
        slots);
  }
  return say(
      "[[walk|go|continue|head|proceed|move|keep going] [2*down|along] the $room|follow the $room]",
      slots);
}

// An instruction uses one name for all rooms of a kind.
std::string Wording::room(std::size_t room) {
  const auto [name, is_new] = names_.try_emplace(home_.home.plan.rooms[room].name);
  if (is_new) name->second = naming_.room(room, rng_);
  return name->second;
}

bool Wording::been_in_another(std::size_t room) const {
  return !naming_.is_stairs(room) &&
         std::ranges::none_of(been_, [&](std::size_t r) { return r == room; }) &&
         std::ranges::any_of(been_, [&](std::size_t r) { return naming_.same_room_name(r, room); });
}

std::string Wording::entered(std::size_t room, double mark) {
  const std::string name = this->room(room);
  if (been_in_another(room)) {
    return say(naming_.rooms_of_name(room) == 2 ? "[2*the other|another] $name"
                                                : "[2*another|a different|the next] $name",
               {{"name", name}});
  }
  if (brief() || !chance(mark)) return "the " + name;
  const auto thing = naming_.mark_of(room, rng_);
  return thing ? "the " + name + " with the " + *thing : "the " + name;
}

std::string Wording::left(std::size_t room) {
  // If only one room is left behind, it needs no name.
  if (been_.size() == 1 && chance(0.15)) return "the room";
  return "the " + this->room(room);
}

std::string Wording::stairs(const PathStretch& stretch) {
  const bool up = stretch.climb > 0;
  const Slots slots{{"up", up ? "up" : "down"},
                    {"flight", say("[3*stairs|steps|staircase|flight of stairs]")},
                    {"verb", up ? say("[2*climb|ascend|mount]") : say("[descend|come down]")},
                    {"end", up ? say("[top|very top]") : say("[bottom|foot]")},
                    {"upstairs", up ? "upstairs" : "downstairs"},
                    {"floor", up ? say("[upper floor|next floor|floor above|upper level]")
                                 : say("[lower floor|floor below|lower level]")}};
  if (stretch.from_storey && stretch.to_storey) {
    return say(
        "[[go|walk|head|go|walk|proceed|travel] $up the $flight|$verb the $flight|"
        "take the stairs $up|$verb the $flight to the $floor|[head|go|walk] $upstairs|"
        "[go|walk] $up the $flight to the $end|go all the way $up the $flight]",
        slots);
  }
  if (stretch.to_storey) {
    return say("[[continue|keep going|carry on] $up the $flight|go $up the rest of the stairs]",
               slots);
  }
  return say("[start $up the $flight|go part of the way $up the $flight]", slots);
}

bool Wording::leaves(const Happening& crossing) const {
  return !naming_.is_way(crossing.from) && naming_.is_way(crossing.to);
}

std::string Wording::door(const Happening& crossing) {
  if (!crossing.opening) return "";
  const Opening& opening = home_.home.plan.openings[*crossing.opening];
  if (opening.kind == OpeningKind::kArch) {
    return say("[2*archway|arch|opening|wide opening|open archway]");
  }
  return opening.leaf > 20 ? say("[door|doorway|open door]") : say("[door|doorway]");
}

std::string Wording::cross(const Happening& crossing, bool straight) {
  const bool has_door = crossing.opening.has_value();
  const Slots slots{{"from", left(crossing.from)},
                    {"to", entered(crossing.to)},
                    {"straight", straight && chance(0.6) ? "straight" : ""},
                    {"door", door(crossing)}};
  if (naming_.same_room_name(crossing.from, crossing.to)) {
    return has_door
               ? say("[go|walk|pass|continue|step] $straight through the $door [2*into|to] $to",
                     slots)
               : say("[go|walk|continue] $straight [on|] into $to", slots);
  }
  if (leaves(crossing)) {
    if (has_door && !brief() && chance(0.4)) {
      return say("[leave|exit|walk out of|go out of] $from [through|by|via] the $door", slots);
    }
    if (!brief() && chance(0.3)) return say("[step|walk|go|head] out of $from into $to", slots);
    return say(
        "[3*leave|3*exit|walk out of|go out of|step out of|head out of|come out of|"
        "get out of] $from",
        slots);
  }
  if (has_door && !brief() && chance(0.4)) {
    return say("[go|walk|pass|step|head|move|proceed] $straight through the $door into $to", slots);
  }
  if (straight && chance(0.5)) {
    return say("[go|walk|head|continue] [3*straight|directly] into $to", slots);
  }
  return into(crossing);
}

std::string Wording::into(const Happening& crossing) {
  const Slots slots{{"to", entered(crossing.to)}};
  if (!brief() && chance(0.15)) {
    return say("[walk|continue|keep going|go on] until you [reach|get to|come to] $to", slots);
  }
  return say(
      "[4*enter|2*go into|2*walk into|step into|head into|pass into|proceed into|move into|"
      "continue into|make your way into] $to",
      slots);
}

// Through a door at one side; empty if it shall not be mentioned.
std::string Wording::door_aside(const PathStretch& stretch, const Happening& crossing,
                                const Slots& slots) {
  const auto first = std::ranges::find(stretch.happenings, HappeningKind::kCross, &Happening::kind);
  const bool counted = first != stretch.happenings.end() && first->opening == crossing.opening;
  const bool names = crossing.to == goal_room_ && !been_in_another(crossing.to);
  if (counted && stretch.door > 0 && chance(0.7)) {
    return say(names ? "[2*take|go through|walk through] the $nth door on [your|the] $side into $to"
                     : "[2*take|go through|walk through] the $nth door on [your|the] $side",
               slots);
  }
  if (brief() || !chance(0.4)) return "";
  if (leaves(crossing)) {
    return say("[leave|exit] $from [through|by|via] the $door [on|to] your $side", slots);
  }
  return say(names ? "[go|walk|head|step] through the $door [on|to] your $side into $to"
                   : "[go|walk|head|step] through the $door [on|to] your $side[| into $to]",
             slots);
}

std::string Wording::turn_and_cross(const PathStretch& stretch, const Happening& crossing) {
  const Slots slots{{"side", side_of(stretch.turn > 0)},
                    {"from", left(crossing.from)},
                    {"to", entered(crossing.to)},
                    {"plain", entered(crossing.to, 0)},
                    {"nth", std::string(kOrdinals.at(stretch.door))},
                    {"door", door(crossing)}};
  const TurnKind turned = turn_of(stretch.turn);
  if (turned == TurnKind::kFull && crossing.opening) {
    std::string text = door_aside(stretch, crossing, slots);
    if (!text.empty()) return text;
  }
  if (turned != TurnKind::kAround && !leaves(crossing) && chance(0.85)) {
    return say(turned == TurnKind::kSlight
                   ? "[2*bear|2*veer|turn slightly|angle|go slightly|take a slight] $side into $to"
                   : "[4*turn|2*go|take a|make a|head] $side into $to|"
                     "enter $plain [on|to] your $side",
               slots);
  }
  const std::string crossed = cross(crossing, false);  // drawn before the words of the turn
  return turn(stretch.turn) + " and " + crossed;
}

std::string Wording::through(const Happening& first, const Happening& second, bool straight) {
  return say(
      "[go|walk|pass|head|move|continue|cut] $straight through the $middle "
      "[2*into|to|and into] $to",
      {{"middle", room(first.to)},
       {"to", entered(second.to)},
       {"straight", straight && chance(0.4) ? "straight" : ""}});
}

std::string Wording::pass(const std::string& thing, bool on_right) {
  const Slots slots{{"thing", thing},
                    {"a", is_plural(thing) ? "the " + thing : with_article(thing)},
                    {"side", side_of(on_right)},
                    {"other", side_of(!on_right)}};
  if (brief()) {
    return say("[2*pass|go past|2*walk past|continue past|head past] the $thing", slots);
  }
  if (chance(0.1)) {
    return say("you [will|should] [see|pass|notice|find] $a on [your|the] $side", slots);
  }
  return say(
      "[2*pass|2*walk past|2*go past|move past|continue past|head past|walk by|go by|"
      "proceed past|stroll past] the $thing [2*on|to] [3*your|the] $side|"
      "[keep|leave] the $thing on your $side|[walk|go] to the $other of the $thing|"
      "[walk|go|continue] [on|ahead] with the $thing on your $side",
      slots);
}

std::string Wording::between(const std::string& a, const std::string& b) {
  return say("[walk|go|pass|walk|squeeze|head] between the $a and the $b", {{"a", a}, {"b", b}});
}

std::string Wording::over(const std::string& thing) {
  return say(
      "[walk|step|go|walk] [over|across] the $thing|[2*cross|traverse] the $thing|"
      "step onto the $thing",
      {{"thing", thing}});
}

std::string Wording::towards(const std::string& thing) {
  return say(
      "[walk|head|go|move|continue|proceed] [towards|toward] the $thing|approach the $thing|"
      "make your way towards the $thing|[aim|make|head] for the $thing|"
      "[walk|go|head] straight [towards|toward|for] the $thing",
      {{"thing", thing}});
}

std::optional<std::string> Wording::at_start(const std::string& thing, double bearing) {
  const double size = std::abs(bearing);
  const Slots slots{{"thing", thing}, {"side", side_of(bearing > 0)}};
  if (size < 15) {
    return say("[facing the $thing|looking at the $thing|with the $thing in front of you]", slots);
  }
  if (size > 160) {
    return say("[with the $thing behind you|with your back to the $thing]", slots);
  }
  if (size < 55 || size > 125) return std::nullopt;
  return say("[standing|starting||] with the $thing [on|to] your $side", slots);
}

std::string Wording::stop(const std::string& where) {
  if (where.starts_with("when") || where.starts_with("once")) {
    return say("[3*stop|halt] $where", {{"where", where}});
  }
  return say("[5*stop|4*wait|2*stand|halt|pause|finish|come to a stop] $where", {{"where", where}});
}

std::string Wording::beside(const std::string& thing, const Neighbour& n) {
  const Slots slots{
      {"thing", thing}, {"side", side_of(n.bearing > 0)}, {"is", is_plural(thing) ? "are" : "is"}};
  const double size = std::abs(n.bearing);
  if (speaker_ == SpeakerKind::kTerse)
    return say("[3*by|at|beside|near|next to] the $thing", slots);
  if (size < 35 && chance(0.5)) {
    return say(
        "[2*in front of|directly in front of|facing|right before|opposite|across from|"
        "when you [reach|get to]] the $thing",
        slots);
  }
  if (size > 55 && size < 125 && !brief() && chance(0.25)) {
    return say(
        "[when the $thing $is|once the $thing $is|with the $thing|by the $thing] "
        "[on|to] your $side",
        slots);
  }
  return say(
      "[3*next to|3*by|beside|2*near|close to|right next to|alongside|adjacent to] the $thing",
      slots);
}

std::string Wording::in_doorway(std::size_t opening) {
  const Opening& o = home_.home.plan.openings[opening];
  const Slots slots{{"a", room(o.room0)},
                    {"b", room(*o.room1)},
                    {"door", o.kind == OpeningKind::kArch ? say("[archway|opening]") : "doorway"}};
  if (naming_.same_room_name(o.room0, *o.room1)) return say("in the $door", slots);
  if (o.kind == OpeningKind::kDoor && chance(0.1)) return say("on the threshold of the $b", slots);
  if (naming_.is_way(*o.room1)) return say("in the $door [of|to] the $a", slots);
  if (naming_.is_way(o.room0)) return say("in the $door [of|to] the $b", slots);
  if (chance(0.7)) {  // coming from one room, the doorway leads to the other
    if (been_.back() == o.room0) return say("in the $door [to|of|leading to] the $b", slots);
    if (been_.back() == *o.room1) return say("in the $door [to|of|leading to] the $a", slots);
  }
  return say("in the $door between the $a and the $b", slots);
}

std::string Wording::by_door(std::size_t opening, std::size_t here) {
  const Opening& o = home_.home.plan.openings[opening];
  if (o.kind == OpeningKind::kEntrance) {
    return say("[by|near|next to|in front of] the [front door|entrance door]");
  }
  const std::string name =
      o.kind == OpeningKind::kArch ? say("[archway|opening]") : say("[door|doorway]");
  const Slots slots{{"door", name}, {"by", say("[by|near|next to|beside|close to]")}};
  if (!o.room1) return say("$by the $door", slots);
  const std::size_t other = o.room0 == here ? *o.room1 : o.room0;
  if (naming_.same_room_name(o.room0, *o.room1) || chance(0.3)) return say("$by the $door", slots);
  return say("$by the $door [to|leading to|of|that leads to] the $other",
             {slots[0], slots[1], {"other", room(other)}});
}

std::optional<std::string> Wording::thing(std::size_t thing, ViewpointIndex from, Rivals rivals) {
  const bool colourful = chance(speaker_ == SpeakerKind::kLandmarks ? 0.6
                                : speaker_ == SpeakerKind::kTerse   ? 0.05
                                                                    : 0.2);
  return naming_.thing(thing, from, colourful ? Detail::kColour : Detail::kPlain, rivals, rng_);
}

}  // namespace enfilade::homes::instructions
