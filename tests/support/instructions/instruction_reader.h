/// \file  For tests: reads what the text of an instruction claims, without knowledge of its writer.
#pragma once
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "enfilade/homes/home.h"
#include "tests/support/instructions/instruction_words.h"

namespace enfilade::homes::instructions::testing {

enum class Side : std::uint8_t { kNone, kLeft, kRight };

/// "the green sofa": objects of the home that fit, by noun and adjectives.
struct ThingNamed {
  std::string words;
  std::vector<std::size_t> fits;
};

struct Claim {
  enum class Kind : std::uint8_t {
    kTurn,
    kAround,
    kStraight,  // where to turn
    kCross,     // from room to room
    kInside,
    kEndOf,  // of a room
    kStairs,
    kUpstairs,
    kTop,  // a flight; on the upper (lower) floor; at a flight's end
    kPass,
    kOver,
    kTowards,
    kBetween,
    kAhead,
    kBehind,
    kBeside,  // an object's place relative to the present position
    kNear,    // at the end: an object
    kInDoorway,
    kByDoor,
    kMiddle,
    kOnStairs,
    kWalk,  // metres
    kStop,
  };
  Kind kind = Kind::kStop;
  bool at_start = false, at_stop = false;
  Side side = Side::kNone;
  bool slight = false, sharp = false;
  bool up = false;
  bool to_end = false, partly = false;            // of the flight
  std::optional<std::set<std::size_t>> from, to;  // rooms that fit the names
  bool another = false;                           // than the one left, of the same name
  bool by_opening = false;                        // through a door or an arch that is spoken of
  std::optional<OpeningKind> opening;
  unsigned nth = 0;
  double metres = 0;
  ThingNamed thing, second;
};

struct Reading {
  std::vector<Claim> claims;
  std::vector<std::string> not_understood;
};

Reading read_instruction(const Home& home, const std::string& text);

/// An object or a room that a text names.
struct Named {
  std::string before;           // the word, or the phrase, before it
  ThingNamed thing;             // without words: it is a room
  std::set<std::size_t> rooms;  // that fit
};
/// In the order of the text.
std::vector<Named> read_names(const Home& home, const std::string& text);

}  // namespace enfilade::homes::instructions::testing
