#include "enfilade/homes/speaking/instructions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <cmath>
#include <cstdint>

namespace enfilade::homes::speaking {
namespace {

constexpr const char* kStairs = "stairs";

enum class TurnPhrase : std::uint8_t { kNone, kLeft, kRight, kAround };

TurnPhrase turn_phrase(Radians difference) {
  const double d = to_degrees(wrap_difference(difference));
  if (std::abs(d) < 40) return TurnPhrase::kNone;
  if (std::abs(d) > 140) return TurnPhrase::kAround;
  return d < 0 ? TurnPhrase::kLeft : TurnPhrase::kRight;
}

const char* say(TurnPhrase turn) {
  constexpr const char* kWords[] = {"go straight", "turn left", "turn right", "turn around"};
  return kWords[static_cast<std::size_t>(turn)];
}

// A stretch of the path within one room.
struct Visit {
  std::string room;
  TurnPhrase before = TurnPhrase::kNone;  // the last turn before the door, of the room before
  TurnPhrase after = TurnPhrase::kNone;   // the first turn inside
  double rise = 0;  // metres from the viewpoint before the room to the one after it
};

std::vector<Visit> visits(const graph::NavGraph& graph, const std::vector<ViewpointIndex>& path,
                          Radians heading, const RoomOf& room_of) {
  std::vector<Visit> found{{room_of(path.front()), TurnPhrase::kNone, TurnPhrase::kNone, 0}};
  TurnPhrase last = TurnPhrase::kNone;  // since the room was entered, once `after` is taken
  Radians before = heading;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const graph::Edge* edge = graph.edge(path[i], path[i + 1]);
    const TurnPhrase turn = turn_phrase(edge->heading - before);
    before = edge->heading;
    if (turn != TurnPhrase::kNone) {
      (found.back().after == TurnPhrase::kNone ? found.back().after : last) = turn;
    }
    found.back().rise += graph.position(path[i + 1]).z - graph.position(path[i]).z;
    const std::string& room = room_of(path[i + 1]);
    if (room == found.back().room) continue;
    const double rise = graph.position(path[i + 1]).z - graph.position(path[i]).z;
    found.push_back({room, last, TurnPhrase::kNone, rise});
    last = TurnPhrase::kNone;
  }
  return found;
}

std::string place(const std::string& room) {
  return fmt::format("{} the {}", room == kStairs ? "on" : "in", room);
}

std::string climb(const Visit& stairs) {
  return fmt::format("go {} the stairs", stairs.rise > 0 ? "up" : "down");
}

std::string sentence(std::string text) {
  text[0] = static_cast<char>(text[0] >= 'a' && text[0] <= 'z' ? text[0] - 'a' + 'A' : text[0]);
  return text + ".";
}

std::string go_out(const Visit& first) {
  return first.room == kStairs ? climb(first) : fmt::format("leave the {}", first.room);
}

// "Leave the kitchen, turn left into the hallway, turn right and stop in the bathroom."
std::string in_one_sentence(const std::vector<Visit>& all) {
  std::vector<std::string> clauses{go_out(all.front())};
  for (std::size_t i = 1; i < all.size(); ++i) {
    const Visit& visit = all[i];
    const bool last = i + 1 == all.size();
    if (visit.before != TurnPhrase::kNone) clauses.emplace_back(say(visit.before));
    if (visit.room == kStairs && !last) {
      clauses.push_back(climb(visit));
    } else if (!last) {
      clauses.push_back(fmt::format("{} into the {}", say(visit.after), visit.room));
    } else {
      const std::string stop = "stop " + place(visit.room);
      clauses.back() += " and " + (visit.after == TurnPhrase::kNone || visit.room == kStairs
                                       ? stop
                                       : fmt::format("{} inside, then {}", say(visit.after), stop));
    }
  }
  return sentence(fmt::format("{}", fmt::join(clauses, ", ")));
}

std::string step(const Visit& visit, bool last) {
  if (visit.room == kStairs) {
    return climb(visit) + (last ? " and wait on them" : " to the other floor");
  }
  if (last) return fmt::format("enter the {} and wait there", visit.room);
  if (visit.after == TurnPhrase::kNone)
    return fmt::format("walk straight through the {}", visit.room);
  return fmt::format("{} and walk through the {}", say(visit.after), visit.room);
}

std::string step_by_step(const std::vector<Visit>& all) {
  const Visit& first = all.front();
  const std::string out =
      first.room == kStairs ? climb(first) : fmt::format("walk out of the {}", first.room);
  std::string text = sentence(
      first.after == TurnPhrase::kNone ? out : fmt::format("{} and {}", say(first.after), out));
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (all[i].before != TurnPhrase::kNone) text += " " + sentence(say(all[i].before));
    text += " " + sentence(step(all[i], i + 1 == all.size()));
  }
  return text;
}

std::string goal_first(const std::vector<Visit>& all, double metres) {
  std::vector<std::string> ways;
  for (std::size_t i = 1; i + 1 < all.size(); ++i) {
    ways.push_back(all[i].room == kStairs ? climb(all[i])
                                          : fmt::format("go through the {}", all[i].room));
  }
  if (ways.empty()) ways.emplace_back("it is the next room");
  return fmt::format("From the {} find the {}. {} Stop after about {:.0f} metres, {}.",
                     all.front().room, all.back().room,
                     sentence(fmt::format("{}", fmt::join(ways, ", then "))), metres,
                     place(all.back().room));
}

}  // namespace

std::vector<std::string> describe_path(const graph::NavGraph& graph,
                                       const std::vector<ViewpointIndex>& path, Radians heading,
                                       const RoomOf& room_of) {
  const std::vector<Visit> all = visits(graph, path, heading, room_of);
  double metres = 0;
  for (std::size_t i = 1; i < path.size(); ++i) metres += graph.edge(path[i - 1], path[i])->length;
  return {in_one_sentence(all), step_by_step(all), goal_first(all, metres)};
}

}  // namespace enfilade::homes::speaking
