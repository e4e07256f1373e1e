/// \file  Room-to-Room annotations: paths and the instructions that describe them.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/graph/graph_set.h"

namespace enfilade::tasks {

/// Instructions of a path that are scored; a few paths have a fourth one, which is trained on only.
inline constexpr std::size_t kScoredInstructions = 3;

/// One entry of `R2R_<split>.json`, as it stands there.
struct PathAnnotation {
  std::int64_t path_id = 0;
  std::string scan;
  Radians heading;                 ///< of the start, [0, 2 pi)
  std::vector<std::string> path;   ///< viewpoint ids; the start only if the goal is hidden
  std::optional<double> distance;  ///< length in metres; none if the goal is hidden
  std::vector<std::string> instructions;

  bool goal_hidden() const noexcept { return path.size() < 2; }
};

/// A whole file.
struct Annotations {
  std::string split;  ///< "train", "val_seen", ...
  std::string file;
  std::vector<PathAnnotation> paths;
};

/// Reads a file. `distance` may be absent, `instructions` may be empty (paths that wait for theirs,
/// as `enfilade sample` writes them), fields of other names are ignored.
/// \throws FileError; InvalidInput listing its faults (up to 1000) with their JSON paths: not JSON,
/// missing, repeated or wrongly typed fields, an empty path, a negative distance, a path_id that
/// another entry has
Annotations load_annotations(const std::filesystem::path& file, std::string split);
Annotations parse_annotations(std::string_view json, const std::string& file, std::string split);

/// The file's content in R2R's format, an entry a line, which load_annotations() reads back equal.
/// \throws ArgumentError for what JSON cannot say: an infinite number, text that is not UTF-8
std::string to_json(const Annotations& annotations);

/// "<path_id>_<k>": the `instr_id` of instruction k of a path.
std::string instruction_id(std::int64_t path_id, std::size_t k);

/// A path whose names have been looked up.
struct ReferencePath {
  std::int64_t path_id = 0;
  ScanIndex scan;
  Radians heading;
  std::vector<ViewpointIndex> viewpoints;  ///< start to goal; the start only if the goal is hidden
};

/// One instruction to follow: what an agent is given, and what it is scored on.
struct Episode {
  std::string instruction_id;
  std::size_t path = 0;         ///< index into EpisodeSet::paths
  std::size_t instruction = 0;  ///< k, 0-based
  std::string text;
};

/// Which instructions of a path become episodes.
enum class Instructions {
  kScored,  ///< the first kScoredInstructions
  kAll,     ///< fourth ones too, for training
};

/// The episodes of a split, with graphs to walk in. Immutable: any thread.
struct EpisodeSet {
  std::string split;
  std::shared_ptr<const graph::GraphSet> graphs;
  std::vector<ReferencePath> paths;
  std::vector<Episode> episodes;  ///< in file order

  /// The episode's reference path, and the graph of its scan. Valid as long as *this.
  const ReferencePath& path_of(const Episode& e) const { return paths[e.path]; }
  const graph::NavGraph& graph_of(const Episode& e) const { return graphs->graph(path_of(e).scan); }
};

/// Metres along the edges of a path. \pre graph is the path's, and look_up_paths() gave the path
double length_of(const ReferencePath& path, const graph::NavGraph& graph);

/// Looks up scans and viewpoints, in the order of the file.
/// \throws InvalidInput listing every unknown scan, unknown or excluded viewpoint, and step between
/// viewpoints that are not adjacent, with JSON paths; errors of graph files
std::vector<ReferencePath> look_up_paths(const Annotations& annotations,
                                         const graph::GraphSet& graphs);

/// look_up_paths() and the instructions to follow.
/// \throws as look_up_paths(); InvalidInput also for each path without an instruction
EpisodeSet make_episodes(const Annotations& annotations,
                         std::shared_ptr<const graph::GraphSet> graphs,
                         Instructions instructions = Instructions::kScored);

}  // namespace enfilade::tasks
