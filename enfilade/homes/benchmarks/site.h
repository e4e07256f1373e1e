/// \file  A home for the writers of benchmarks: objects in view, rooms and words for them.
/// Internal.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/capture/object_boxes.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/instructions/naming.h"
#include "enfilade/homes/instructions/speaker.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::homes::benchmarks {

/// Words for a room, and the rooms that they fit.
struct RoomWords {
  std::string text;               ///< "the bedroom with the red rug on the second floor"
  std::vector<std::size_t> fits;  ///< ascending; with the room that was meant
};

/// A home with its graph. Its inputs must outlive it.
class Site {
 public:
  /// Looks for the objects around each viewpoint, on `threads`. \pre graph's viewpoints are in the
  /// home
  Site(const BuiltHome& built, const graph::NavGraph& graph, const instructions::Sights& sights,
       int threads);

  const Home& home() const noexcept { return spoken_.home; }
  const graph::NavGraph& graph() const noexcept { return spoken_.graph; }
  const instructions::SpokenHome& spoken() const noexcept { return spoken_; }
  const instructions::Naming& naming() const noexcept { return naming_; }

  /// The objects around a viewpoint, at most 3 m away, that views show.
  std::span<const capture::ObjectInView> around(ViewpointIndex v) const { return around_[v.at()]; }
  /// The same as REVERIE's file has them, of all included viewpoints. \throws as ObjectBoxes::add()
  void add_boxes(tasks::ObjectBoxes& boxes) const;
  /// Objects around a viewpoint that stand in its room, and that people would mention.
  std::vector<std::size_t> things_at(ViewpointIndex v) const;
  /// A viewpoint's view of an object; nullptr if it is not around it.
  const capture::ObjectInView* view_of(std::size_t thing, ViewpointIndex v) const;

  /// Included viewpoints in a room, ascending.
  const std::vector<ViewpointIndex>& in_room(std::size_t room) const { return in_room_[room]; }
  std::optional<std::size_t> room(ViewpointIndex v) const { return spoken_.sights.room(v); }
  /// Words for a room that give its storey, or an object in it, if its name fits others.
  RoomWords room_words(std::size_t room, Rng& rng) const;
  /// Objects in those rooms.
  std::vector<std::size_t> things_in(std::span<const std::size_t> rooms) const;
  /// Words for an object that fit no other in those rooms; no value if there are none.
  std::optional<std::string> thing_words(std::size_t thing, std::span<const std::size_t> rooms,
                                         Rng& rng) const;

  /// The viewpoints of a path. \pre they are in the graph
  std::vector<ViewpointIndex> look_up(const std::vector<std::string>& ids) const;
  std::vector<std::string> ids(std::span<const ViewpointIndex> path) const;
  /// Heading of a step, radians, world.
  double heading(ViewpointIndex from, ViewpointIndex to) const;

 private:
  instructions::SpokenHome spoken_;
  instructions::Naming naming_;
  std::vector<std::vector<capture::ObjectInView>> around_;  // by viewpoint
  std::vector<std::vector<ViewpointIndex>> in_room_;        // by room
  std::vector<std::optional<std::size_t>> thing_of_;        // by object
};

/// Random numbers for one path and one purpose, so that the draws for one do not change others.
Rng rng_for(std::uint64_t seed, const tasks::PathAnnotation& path, const char* purpose);

}  // namespace enfilade::homes::benchmarks
