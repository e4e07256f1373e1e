/// \file  Simulated speakers who describe paths through synthetic homes in English. Internal.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/home.h"
#include "enfilade/mesh/ray_tracer.h"

namespace enfilade::homes::instructions {

/// The three kinds of speakers.
enum class SpeakerKind : std::uint8_t {
  kTerse,       ///< "Leave the bedroom, turn right, stop by the stairs."
  kLandmarks,   ///< names objects in view, with colour and side
  kStepByStep,  ///< gives each turn, door, staircase and stretch in order
  kGuide,       ///< omits nothing, as people who speak along the path (RxR's guides)
};
/// Those of Room-to-Room, one for each instruction of a path.
inline constexpr std::array kSpeakers{SpeakerKind::kTerse, SpeakerKind::kLandmarks,
                                      SpeakerKind::kStepByStep};

/// An object in view.
struct ThingInView {
  std::size_t thing = 0;  ///< index in home.things
  double heading = 0;     ///< radians, world, of the middle of its visible part
  double elevation = 0;
  double distance = 0;  ///< metres, to the same
  double share = 0;     ///< of the whole sphere of directions, [0, 1]
};

/// Things in view from all viewpoints of a home. Immutable.
class ThingsInView {
 public:
  /// Casts `rays` rays from each viewpoint, spread evenly over all directions. An object is in view
  /// if at least 3 rays hit it.
  /// \pre graph's viewpoints are in the home
  ThingsInView(const Home& home, const mesh::RayTracer& tracer, const graph::NavGraph& graph,
               std::size_t rays = 8192, int threads = 0);
  /// Things in view, the largest share first.
  std::span<const ThingInView> at(ViewpointIndex v) const { return sights_[v.at()]; }
  /// The room of the floor below the viewpoint, by room_at().
  std::optional<std::size_t> room(ViewpointIndex v) const { return rooms_[v.at()]; }

 private:
  std::vector<std::vector<ThingInView>> sights_;
  std::vector<std::optional<std::size_t>> rooms_;
};

/// A home with the data that speakers need.
struct SpokenHome {
  const Home& home;
  const graph::NavGraph& graph;
  const ThingsInView& sights;
};

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
/// An instruction, and its parts, for a path that begins at its first viewpoint with that heading
/// (radians, world). Everything in it is true at that point of the path. It has turns (relative to
/// the direction faced there), doors and stairs in order, objects in view and their side, rooms,
/// and where to stop. The least important facts are left out until it has the speaker's usual
/// length (Habits). The same arguments give the same words. \pre at least 2 viewpoints
Spoken describe(const SpokenHome& home, std::span<const ViewpointIndex> viewpoints, double heading,
                SpeakerKind speaker, std::uint64_t seed);

}  // namespace enfilade::homes::instructions
