/// \file  Simulated speakers who describe paths through model homes in English. Internal.
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

/// The three kinds of speakers.
enum class Speaker : std::uint8_t {
  kTerse,       ///< "Leave the bedroom, turn right, stop by the stairs."
  kLandmarks,   ///< names things in view, with colour and side
  kStepByStep,  ///< says each turn, door, staircase and stretch in order
};
inline constexpr std::array kSpeakers{Speaker::kTerse, Speaker::kLandmarks, Speaker::kStepByStep};

/// What a speaker knows of a home.
struct SpokenHome {
  const Home& home;
  const graph::NavGraph& graph;
  const Sights& sights;
};

/// An instruction for a path that begins at its first viewpoint with that heading (radians, world).
/// Everything in it is true at that point of the path: turns (relative to the direction faced
/// there), doors and stairs in their order, things in view and their side, rooms entered and left,
/// where to stop. The least important facts are left out until it has the speaker's usual length
/// (habits.h). The same arguments give the same words. \pre at least 2 viewpoints
std::string describe(const SpokenHome& home, std::span<const ViewpointIndex> viewpoints,
                     double heading, Speaker speaker, std::uint64_t seed);

}  // namespace enfilade::homes::speaking
