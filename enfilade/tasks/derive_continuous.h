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

/// What came of walking through the nodes of a path.
struct WalkedNodes {
  std::string obstacle = {};  ///< why a body cannot walk it, in words; empty: it can
  std::optional<double> geodesic_distance = {};  ///< from the first node to the last, metres
};

/// The floor of buildings, as far as episodes need it: of a navigation mesh, or guessed.
class EpisodeFloor {
 public:
  EpisodeFloor() = default;
  EpisodeFloor(const EpisodeFloor&) = delete;
  EpisodeFloor& operator=(const EpisodeFloor&) = delete;
  virtual ~EpisodeFloor() = default;

  /// Where a body stands for a viewpoint, in our world frame. No value where it cannot stand.
  /// \pre viewpoint < graph.size()
  virtual std::optional<Vec3d> node_of(const graph::NavGraph& graph,
                                       ViewpointIndex viewpoint) const = 0;
  /// Whether a body can walk from node to node, in their order. \pre not empty; node_of() gave each
  virtual WalkedNodes walk(const graph::NavGraph& graph, std::span<const Vec3d> nodes) const = 0;
};

/// The floor without a mesh: the height of the viewpoint above it is that of the connectivity file.
/// Everything can be walked, and no geodesic distance is known.
class GuessedFloor final : public EpisodeFloor {
 public:
  /// What VLN-CE's nodes lie above the floor of the connectivity files, metres: the median over
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
  std::string scene_folder = "mp3d";  ///< a scene is "<folder>/<scan>/<scan>.glb"
  std::int64_t first_id = 1;          ///< of the first episode; the others follow without gaps
  /// Whose tokens instructions get (InstructionEncoder), and which goes into the file. No value: no
  /// tokens, and a vocabulary without words.
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

/// What derive_continuous() gives.
struct DerivedEpisodes {
  ContinuousEpisodes episodes;       ///< of each path its instructions, in the order of the file
  std::vector<DroppedPath> dropped;  ///< in the order of the file
};

/// An episode for each instruction of each path that a body can walk: a viewpoint has one node
/// wherever it occurs, a path keeps all its instructions (R2R's fourth ones too) or none. Ids are
/// numbers, and texts of RxR, as in VLN-CE's files. Paths with hidden goals give episodes with
/// hidden goals. The floor is asked from one thread, for one scan after the other, once a viewpoint
/// and once a path. \throws ArgumentError for other annotations than R2R's, R2R-Last's, R4R's and
/// RxR's; InvalidInput and errors of graph files as look_up_paths(); what the floor throws
DerivedEpisodes derive_continuous(const Annotations& annotations, const graph::GraphSet& graphs,
                                  const EpisodeFloor& floor, const DeriveOptions& options = {});

}  // namespace enfilade::tasks
