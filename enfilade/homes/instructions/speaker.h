/// \file  Simulated speakers who describe paths through synthetic homes in English. Internal.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/home.h"
#include "enfilade/homes/instructions/sights.h"

namespace enfilade::homes::instructions {

/// The three kinds of speakers.
enum class Speaker : std::uint8_t {
  kTerse,       ///< "Leave the bedroom, turn right, stop by the stairs."
  kLandmarks,   ///< names objects in view, with colour and side
  kStepByStep,  ///< gives each turn, door, staircase and stretch in order
  kGuide,       ///< omits nothing, as people who speak along the path (RxR's guides)
};
/// Those of Room-to-Room, one for each instruction of a path.
inline constexpr std::array kSpeakers{Speaker::kTerse, Speaker::kLandmarks, Speaker::kStepByStep};

/// A home with the data that speakers need.
struct SpokenHome {
  const Home& home;
  const graph::NavGraph& graph;
  const Sights& sights;
};

/// An instruction for a path that begins at its first viewpoint with that heading (radians, world).
/// Everything in it is true at that point of the path. It has turns (relative to the direction
/// faced there), doors and stairs in order, objects in view and their side, rooms, and where to
/// stop. The least important facts are left out until it has the speaker's usual length (habits.h).
/// The same arguments give the same words.
/// \pre at least 2 viewpoints
std::string describe(const SpokenHome& home, std::span<const ViewpointIndex> viewpoints,
                     double heading, Speaker speaker, std::uint64_t seed);

/// A piece of an instruction, with the words that join it to the piece before.
struct SpokenPart {
  std::string text;
  /// The part of the path that it describes: indices into the path, both included. They are equal
  /// for a turn on the spot, or a stop.
  std::size_t first = 0, last = 0;
};
struct Spoken {
  std::string text;
  /// In order; their texts are the whole except for blanks between them. Each begins on the path
  /// where the one before ends, the first at the start, and the last ends at the end.
  std::vector<SpokenPart> parts;
};
/// describe(), and which part of the text describes which part of the path.
Spoken describe_in_parts(const SpokenHome& home, std::span<const ViewpointIndex> viewpoints,
                         double heading, Speaker speaker, std::uint64_t seed);

}  // namespace enfilade::homes::instructions
