/// \file  Made-up people who describe paths through model homes in English. SYNTHETIC.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/home.h"
#include "enfilade/homes/speaking/sights.h"

namespace enfilade::homes::speaking {

/// Habits of three kinds of people.
enum class Speaker : std::uint8_t {
  kTerse,       ///< "Leave the bedroom, turn right, stop by the stairs."
  kLandmarks,   ///< says what one sees: things with colour and side
  kStepByStep,  ///< each turn, door, stair and stretch in order
};
inline constexpr std::array kSpeakers{Speaker::kTerse, Speaker::kLandmarks, Speaker::kStepByStep};

/// What a speaker knows of a home: everything true of it, nothing else.
struct SpokenHome {
  const Home& home;
  const graph::NavGraph& graph;
  const Sights& sights;
};

/// An instruction for a path, from its first viewpoint, looking to `heading` (radians, world), to
/// its last. Everything said is true at that point of the path: turns (against the direction one
/// faces there), doors and stairs in the order met, things in view and on the side said, rooms
/// entered and left, where to stop. What says least is left out, down to the length that the
/// speaker cares for (detail/habits.h). The same arguments give the same words. \pre viewpoints has
/// at least 2
std::string describe(const SpokenHome& home, std::span<const ViewpointIndex> viewpoints,
                     double heading, Speaker speaker, std::uint64_t seed);

}  // namespace enfilade::homes::speaking
