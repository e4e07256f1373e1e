/// \file  Writers of the benchmarks' annotations, and a home for them: objects in view, words.
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
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/pose_trace.h"

namespace enfilade::homes::benchmarks {

/// Words for a room, and the rooms that they fit.
struct RoomWords {
  std::string text;               ///< "the bedroom with the red rug on the second floor"
  std::vector<std::size_t> fits;  ///< ascending; with the room that was meant
};

/// A home with its graph. Its inputs must outlive it.
class DescribedHome {
 public:
  /// Looks for the objects around each viewpoint, on `threads`. \pre graph's viewpoints are in the
  /// home
  DescribedHome(const BuiltHome& built, const graph::NavGraph& graph,
                const instructions::ThingsInView& sights, int threads);

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

/// R2R-Last: the last sentence of each instruction.
tasks::PathAnnotation last_sentences(tasks::PathAnnotation path);
/// R2R-Back: the path and its way back, with a sentence that requests it. The turning point is the
/// path's end.
tasks::PathAnnotation there_and_back(tasks::PathAnnotation path);
/// Fine-grained R2R: the pieces of each instruction and of the path.
/// \param spoken  of each instruction \pre as many as instructions
tasks::PathAnnotation in_pieces(tasks::PathAnnotation path,
                                const std::vector<std::vector<instructions::SpokenPart>>& spoken);

/// RxR: the guides of a path, who speak along it, and a follower of each.
struct GuidedPath {
  std::vector<tasks::PathAnnotation> guides;  ///< one instruction each
  std::vector<tasks::Demonstration> walks;
  std::vector<tasks::PoseTrace> traces;  ///< poses of the guides
};

/// Two guides, of India and of the United States. Each describes every event of the path, step by
/// step, with the time of each word; between two pieces the guide moves on. Three out of four
/// followers take the path, others turn back once, or stop a step early. Their metrics are those of
/// their trajectory against the path. Traces have a snapshot at the beginning of each piece, and at
/// each step. Instruction ids are 10 times the path's id plus 1 and 2.
GuidedPath write_guides(const DescribedHome& site, const tasks::PathAnnotation& path,
                        std::uint64_t seed);

/// REVERIE: the same path with three short requests, for up to two objects that its last viewpoint
/// shows. Room and object are named so that no other object of the home fits both. Empty if no
/// object there is distinguishable.
std::vector<tasks::PathAnnotation> write_requests(const DescribedHome& site,
                                                  const tasks::PathAnnotation& path,
                                                  std::uint64_t seed);

/// CVDN: a game of a navigator, who searches for an object, and an oracle, who has the shortest
/// path. Its instances are in order, each with the turns so far. The goal is the room where the
/// path ends, the target an object in it. The oracle describes the next steps of a shortest path to
/// the room, at most 5. The navigator follows them, or stops early, and goes a little astray before
/// the first question. Roles, questions and answers are true at their viewpoint. The ids are left
/// to the caller; the group is the path's id. No instance if the start is in the room, or if it has
/// no object to search for.
std::vector<tasks::PathAnnotation> write_dialogue(const DescribedHome& site,
                                                  const tasks::PathAnnotation& path,
                                                  std::uint64_t seed);

/// SOON: paths from several starts to viewpoints that show one object, all with the same three
/// descriptions and boxes. The first start is the path's own. A description has four texts and the
/// whole: the object's name, its appearance, its neighbours, its place. Viewpoints from which its
/// outline lies across heading 0 have no box, as the public scorers cannot handle one. The ids are
/// left to the caller; the group is the path's id. Empty if no object at the path's end has a
/// description that fits no other.
std::vector<tasks::PathAnnotation> write_descriptions(const DescribedHome& site,
                                                      const tasks::PathAnnotation& path,
                                                      std::uint64_t seed);

}  // namespace enfilade::homes::benchmarks
