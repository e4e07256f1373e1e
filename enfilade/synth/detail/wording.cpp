#include "enfilade/synth/detail/wording.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace enfilade::synth::detail {
namespace {

std::string side_of(bool right) { return right ? "right" : "left"; }

constexpr std::array<std::string_view, 13> kNumbers{"zero", "one",    "two",   "three", "four",
                                                    "five", "six",    "seven", "eight", "nine",
                                                    "ten",  "eleven", "twelve"};
constexpr std::array<std::string_view, 5> kOrdinals{"", "first", "second", "third", "fourth"};

}  // namespace

bool Wording::brief() {
  return speaker_ == Speaker::kTerse || (speaker_ == Speaker::kLandmarks && chance(0.6));
}

std::string Wording::turn(double degrees) {
  const Slots slots{{"side", side_of(degrees > 0)}};
  if (turn_of(degrees) == Turn::kSlight) {
    return say(
        "[bear|bear|veer|turn slightly|go slightly|angle to the|curve to the|turn a little|"
        "turn a bit|turn slightly to the|make a slight|veer off to the|head slightly|"
        "turn gently|drift to the|bear off to the] $side",
        slots);
  }
  if (turn_of(degrees) == Turn::kAround) {
    return say(
        "[turn around|turn around|turn all the way around|turn yourself around|"
        "turn completely around|make a complete turn around|spin around|make a U-turn|"
        "do an about-face|turn back to face the other way]");
  }
  if (brief()) {
    return say("[turn $side|turn $side|go $side|take a $side|make a $side|hang a $side]", slots);
  }
  return say(
      "[turn $side|turn $side|take a $side|make a $side|turn to the $side|turn to your $side|"
      "make a $side turn|take a $side turn|make a turn to the $side|swing $side|"
      "rotate to your $side|pivot $side|go to your $side]",
      slots);
}

std::string Wording::straight() {
  return say(
      "[[go|walk|head|keep going|carry on|proceed|move] "
      "[straight|straight ahead|straight on|forward]|continue [straight|straight "
      "ahead|forward|onward]|"
      "keep [straight|walking straight|moving forward]]");
}

std::string Wording::walk(double metres) {
  const auto whole = static_cast<std::size_t>(std::lround(metres));
  std::string how_far;
  if (whole <= 2) {
    how_far = say("[a couple of [metres|meters|paces]|a short way|a little way]");
  } else if (whole <= 12) {
    const Slots number{{"n", std::string(kNumbers.at(whole))}};
    how_far = say("[about $n|roughly $n|some $n|approximately $n] [metres|meters]", number);
  } else {
    how_far = say("[a long way|quite a distance]");
  }
  return say(
      "[$go for $far|[walk|go|move|advance] $far [ahead|forward|straight ahead]|"
      "[continue|proceed|keep walking|stay straight] for $far]",
      {{"go", straight()}, {"far", how_far}});
}

std::string Wording::along(const Stretch& stretch, bool with_turn) {
  const Slots slots{{"room", room(stretch.room_after)}, {"side", side_of(stretch.turn > 0)}};
  if (with_turn) {
    return say("[turn|go|head] $side [down|along] the $room|take a $side [down|along] the $room",
               slots);
  }
  if (stretch.to_end) {
    return say("[walk|go|continue|head|keep walking|follow] [all the way|] to the end of the $room",
               slots);
  }
  return say(
      "[[walk|go|continue|head|proceed|move|keep going] [down|along] the $room|"
      "follow the $room]",
      slots);
}

std::string Wording::room_with(std::size_t room) {
  const std::string name = this->room(room);
  if (speaker_ == Speaker::kTerse || !chance(0.35)) return name;
  const auto mark = naming_.mark_of(room, rng_);
  return mark ? name + " with the " + *mark : name;
}

std::string Wording::stairs(const Stretch& stretch) {
  const bool up = stretch.climb > 0;
  const Slots slots{{"up", up ? "up" : "down"},
                    {"flight", say("[stairs|stairs|steps|staircase|flight of stairs]")},
                    {"verb", up ? say("[climb|ascend|mount]") : say("[descend|come down]")},
                    {"end", up ? say("[top|very top]") : say("[bottom|foot]")},
                    {"floor", up ? say("[upper floor|next floor|floor above|upper level]")
                                 : say("[lower floor|floor below|lower level]")}};
  if (stretch.from_storey && stretch.to_storey) {
    return say(
        "[[go|walk|head|proceed|travel] $up the $flight|$verb the $flight|take the stairs $up|"
        "[go|walk] $up the $flight to the [$end|$floor]|$verb the $flight to the [$end|$floor]|"
        "go all the way $up the $flight|head $upstairs|go $upstairs|"
        "follow the stairs $up to the $floor]",
        {slots[0],
         slots[1],
         slots[2],
         slots[3],
         slots[4],
         {"upstairs", up ? "upstairs" : "downstairs"}});
  }
  if (stretch.to_storey) {
    return say(
        "[[continue|keep going|carry on] $up the $flight|"
        "go $up the rest of the stairs[| to the $end]]",
        slots);
  }
  return say(
      "[start $up the $flight|go part of the way $up the $flight|begin to go $up the $flight]",
      slots);
}

bool Wording::leaves(const Happening& crossing) const {
  return !naming_.is_way(crossing.from) && naming_.is_way(crossing.to);
}

std::string Wording::door(const Happening& crossing) {
  if (!crossing.opening) return "";
  const Opening& opening = home_.home.plan.openings[*crossing.opening];
  if (opening.kind == Opening::Kind::kArch) {
    return say("[archway|archway|arch|opening|wide opening|open archway]");
  }
  return opening.leaf > 20 ? say("[door|doorway|open door]") : say("[door|doorway|doorway]");
}

std::string Wording::cross(const Happening& crossing) {
  const bool same = naming_.same_room_name(crossing.from, crossing.to);
  const Slots slots{{"from", room(crossing.from)},
                    {"to", same ? room(crossing.to) : room_with(crossing.to)},
                    {"door", door(crossing)}};
  const bool has_door = crossing.opening.has_value();
  if (same) {
    return has_door
               ? say("[go|walk|pass|continue|step] through the $door[| into the next $to]", slots)
               : say("[go|walk|continue] on into the next $to", slots);
  }
  if (brief() && crossing.opening && chance(0.8)) {
    return leaves(crossing) ? say("[leave|exit|leave|exit|walk out of|go out of] the $from", slots)
                            : say("[enter|enter|go into|walk into] the $to", slots);
  }
  if (leaves(crossing)) {
    if (has_door && chance(0.3)) {
      return say("[leave|exit|walk out of|go out of] the $from [through|by|via] the $door", slots);
    }
    if (speaker_ != Speaker::kTerse && chance(0.35)) {
      return say("[step|walk|go|head|come|move] out of the $from into the $to", slots);
    }
    return say(
        "[leave|leave|exit|exit|walk out of|go out of|step out of|head out of|come out of|"
        "move out of] the $from",
        slots);
  }
  if (has_door && chance(speaker_ == Speaker::kStepByStep ? 0.55 : 0.3)) {
    return say(
        "[go|walk|pass|step|head|move|proceed|cross] through the $door "
        "[into|into|to enter|that leads into|leading to] the $to",
        slots);
  }
  if (!naming_.is_stairs(crossing.from) && chance(0.2)) {
    return say("[go|walk|move|continue|cross over|pass] from the $from [into|to] the $to", slots);
  }
  return into(crossing);
}

std::string Wording::into(const Happening& crossing) {
  return say(
      "[enter|enter|go into|walk into|step into|head into|proceed into|move into|"
      "continue into|make your way into|come into] the $to",
      {{"to", room_with(crossing.to)}});
}

std::string Wording::turn_and_cross(const Stretch& stretch, const Happening& crossing) {
  const Slots slots{{"side", side_of(stretch.turn > 0)},
                    {"turn", turn(stretch.turn)},
                    {"from", room(crossing.from)},
                    {"to", room(crossing.to)},
                    {"nth", std::string(kOrdinals.at(stretch.door))},
                    {"door", door(crossing)},
                    {"cross", cross(crossing)}};
  const bool full = turn_of(stretch.turn) == Turn::kFull;
  const bool terse = brief();
  const bool same = naming_.same_room_name(crossing.from, crossing.to);
  const auto first =
      std::ranges::find(stretch.happenings, Happening::Kind::kCross, &Happening::kind);
  const bool counted = first != stretch.happenings.end() && first->opening == crossing.opening;
  if (full && counted && stretch.door > 0 && chance(terse ? 0.5 : 0.75)) {
    return say(same || terse
                   ? "take the $nth door on [your|the] $side"
                   : "[take|take|go through|walk through] the $nth door on [your|the] $side"
                     "[| into the $to]",
               slots);
  }
  if (terse && full && !same) {
    return say(leaves(crossing) ? "turn $side out of the $from|"
                                  "turn $side into the $to"
                                : "[turn|turn|go|take a|make a] $side into the $to",
               slots);
  }
  if (full && crossing.opening && !same && chance(0.45)) {
    if (leaves(crossing)) {
      return say("[leave|exit] the $from [through|by|via|using] the $door [on|to] your $side",
                 slots);
    }
    return say("[go|walk|head|step] through the $door [on|to] your $side [into|to] the $to", slots);
  }
  if (full && !same && !leaves(crossing) && chance(0.6)) {
    return say("[turn|take a|go|make a|head] $side into the $to|enter the $to on your $side",
               slots);
  }
  return say("$turn and $cross", slots);
}

std::string Wording::through(const Happening& first, const Happening& second) {
  return say(
      "[go|walk|pass|head|move|continue|cut] [straight|] through the $middle "
      "[into|to|and into|and on into] the $to",
      {{"middle", room(first.to)}, {"to", room(second.to)}});
}

std::string Wording::pass(const std::string& thing, bool on_right) {
  const Slots slots{{"thing", thing},
                    {"a", is_plural(thing) ? "the " + thing : with_article(thing)},
                    {"is", is_plural(thing) ? "are" : say("[is|stands]")},
                    {"side", side_of(on_right)},
                    {"other", side_of(!on_right)}};
  if (speaker_ == Speaker::kTerse) return say("[pass|go past|walk past] the $thing", slots);
  return say(
      "[pass|walk past|go past|move past|continue past|head past|walk by|go by|stroll past] "
      "the $thing [on|on|to] [your|your|the] $side|"
      "[pass|walk past|go past] the $thing [on|on|to] [your|your|the] $side|"
      "[keep|leave] the $thing on your $side|"
      "[go|walk|continue|move] [on|forward|ahead], [passing|keeping|leaving] the $thing "
      "[on|to] your $side|"
      "[you will|you should|you'll] [see|notice|find|pass|spot] $a [on|to] your $side|"
      "pass by the $thing [on|to] your $side|"
      "walk to the $other of the $thing|"
      "proceed past the $thing that $is on your $side",
      slots);
}

std::string Wording::between(const std::string& a, const std::string& b) {
  return say("[walk|go|pass|move|squeeze|head] between the $a and the $b", {{"a", a}, {"b", b}});
}

std::string Wording::over(const std::string& thing) {
  return say("[walk|step|go|move] [over|across] the $thing|cross the $thing", {{"thing", thing}});
}

std::string Wording::towards(const std::string& thing) {
  return say(
      "[walk|head|go|move|continue|proceed] [towards|toward|in the direction of] the $thing|"
      "make your way towards the $thing|aim for the $thing|make for the $thing|"
      "walk straight [towards|toward] the $thing|approach the $thing|"
      "[walk|head|go] straight for the $thing",
      {{"thing", thing}});
}

std::optional<std::string> Wording::at_start(const std::string& thing, double bearing) {
  const double size = std::abs(bearing);
  const Slots slots{{"thing", thing}, {"side", side_of(bearing > 0)}};
  if (size < 15) {
    return say(
        "[facing the $thing|looking at the $thing|starting out facing the $thing|"
        "with the $thing [ahead|in front] of you]",
        slots);
  }
  if (size > 160) {
    return say(
        "[with the $thing behind you|with your back to the $thing|"
        "[starting|standing] with your back [to|towards] the $thing]",
        slots);
  }
  if (size < 55 || size > 125) return std::nullopt;
  return say("[[standing|starting|beginning] |]with the $thing [on|to] your $side", slots);
}

std::string Wording::stop(const std::string& where) {
  return say(
      "[stop|stop|stop|wait|wait|halt|stand|come to a stop|come to a halt|pause|finish] $where",
      {{"where", where}});
}

std::string Wording::beside(const std::string& thing, const Neighbour& n) {
  const Slots slots{
      {"thing", thing}, {"side", side_of(n.bearing > 0)}, {"is", is_plural(thing) ? "are" : "is"}};
  const double size = std::abs(n.bearing);
  if (size < 35 && chance(0.6))
    return say("[in front of|facing|right before|before] the $thing", slots);
  if (size > 55 && size < 125 && speaker_ != Speaker::kTerse && chance(0.4)) {
    return say(
        "[when the $thing $is|once the $thing $is|so that the $thing $is|with the $thing|"
        "by the $thing] [on|to] your $side",
        slots);
  }
  return say("[next to|next to|by|by|beside|near|close to|at|alongside] the $thing", slots);
}

std::string Wording::in_doorway(std::size_t opening) {
  const Opening& o = home_.home.plan.openings[opening];
  const Slots slots{
      {"a", room(o.room0)},
      {"b", room(*o.room1)},
      {"door", o.kind == Opening::Kind::kArch ? say("[archway|opening]") : "doorway"}};
  if (naming_.same_room_name(o.room0, *o.room1)) return say("in the $door", slots);
  if (naming_.is_way(*o.room1)) return say("in the $door [of|to] the $a", slots);
  if (naming_.is_way(o.room0)) return say("in the $door [of|to] the $b", slots);
  return say("in the $door between the $a and the $b", slots);
}

std::string Wording::by_door(std::size_t opening, std::size_t here) {
  const Opening& o = home_.home.plan.openings[opening];
  if (o.kind == Opening::Kind::kEntrance) {
    return say("[by|near|next to|in front of] the [front door|entrance door]");
  }
  const std::string name =
      o.kind == Opening::Kind::kArch ? say("[archway|opening]") : say("[door|doorway]");
  const Slots slots{{"door", name}, {"by", say("[by|near|next to|beside|close to]")}};
  if (!o.room1) return say("$by the $door", slots);
  const std::size_t other = o.room0 == here ? *o.room1 : o.room0;
  if (naming_.same_room_name(o.room0, *o.room1) || chance(0.3)) return say("$by the $door", slots);
  return say("$by the $door [to|leading to|of|that leads to] the $other",
             {slots[0], slots[1], {"other", room(other)}});
}

std::optional<std::string> Wording::thing(std::size_t thing, ViewpointIndex from) {
  const bool colourful = speaker_ == Speaker::kLandmarks ? chance(0.7) : chance(0.2);
  return naming_.thing(thing, from, colourful ? Detail::kColour : Detail::kPlain, rng_);
}

}  // namespace enfilade::synth::detail
