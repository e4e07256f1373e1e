/// \file  Episodes in continuous space made from annotations of graphs, as VLN-CE's were made from
/// R2R and RxR.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::tasks {

/// Result of following the nodes of a path.
struct WalkedNodes {
  std::string obstacle = {};  ///< reason why the body cannot follow it; empty: it can
  std::optional<double> geodesic_distance = {};  ///< from the first node to the last, metres
};

/// The floor of buildings, as far as episodes need it: of a navigation mesh, or guessed.
class EpisodeFloor {
 public:
  EpisodeFloor() = default;
  EpisodeFloor(const EpisodeFloor&) = delete;
  EpisodeFloor& operator=(const EpisodeFloor&) = delete;
  virtual ~EpisodeFloor() = default;

  /// Position of a body for a viewpoint, in our world frame. No value if there is no floor.
  /// \pre viewpoint < graph.size()
  virtual std::optional<Vec3d> node_of(const graph::NavGraph& graph,
                                       ViewpointIndex viewpoint) const = 0;
  /// Whether a body can move from node to node, in their order. \pre not empty; node_of() gave each
  virtual WalkedNodes walk(const graph::NavGraph& graph, std::span<const Vec3d> nodes) const = 0;
};

/// The floor without a mesh: the height of the viewpoint above it is that of the connectivity file.
/// Everything is walkable, and no geodesic distance is known.
class GuessedFloor final : public EpisodeFloor {
 public:
  /// Height of VLN-CE's nodes above the floor of the connectivity files, metres: the median over
  /// the 6,643 viewpoints of its version 1-2.
  static constexpr double kAboveFloor = 0.107;

  std::optional<Vec3d> node_of(const graph::NavGraph& graph,
                               ViewpointIndex viewpoint) const override;
  WalkedNodes walk(const graph::NavGraph& graph, std::span<const Vec3d> nodes) const override;
};

/// Which way episodes begin.
enum class StartHeadings : std::uint8_t {
  kOfPath,  ///< the annotation's, as in VLN-CE since version 1-3
  kRandom,  ///< one a trajectory, from the seed, as before
};

/// How episodes are made.
struct DeriveOptions {
  StartHeadings start_headings = StartHeadings::kOfPath;
  std::uint64_t seed = 1;             ///< of random headings
  double radius = 3;                  ///< of goals, metres \pre 0 or more
  std::string scene_folder = "mp3d";  ///< of scene_of_scan()
  std::int64_t first_id = 1;          ///< id of the first episode; the others follow without gaps
  /// Encoder of the instructions' tokens, and the vocabulary in the file. No value: no tokens, and
  /// a vocabulary without words.
  std::optional<InstructionVocabulary> vocabulary = {};
};

/// A path that has become no episode.
struct DroppedPath {
  std::size_t path = 0;  ///< index into Annotations::paths
  std::string id;        ///< its path_id
  std::string scan;
  std::string why;  ///< in words
  friend bool operator==(const DroppedPath&, const DroppedPath&) = default;
};

/// The result of derive_continuous().
struct DerivedEpisodes {
  ContinuousEpisodes episodes;       ///< path by path, each path's instructions in file order
  std::vector<DroppedPath> dropped;  ///< in the order of the file
};

/// An episode for each instruction of each path that a body can follow. A viewpoint has one node in
/// all paths. A path keeps all its instructions (R2R's fourth ones too) or none. Ids are numbers,
/// and texts of RxR, as in VLN-CE's files. Paths with hidden goals give episodes with hidden goals.
/// The floor is called from one thread, scan after scan, once per viewpoint and once per path.
/// \throws ArgumentError for other annotations than R2R's, R2R-Last's, R4R's and RxR's
/// \throws InvalidInput and errors of graph files as look_up_paths(); the floor's errors
DerivedEpisodes derive_continuous(const Annotations& annotations, const graph::GraphSet& graphs,
                                  const EpisodeFloor& floor, const DeriveOptions& options = {});

}  // namespace enfilade::tasks
