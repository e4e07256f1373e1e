/// \file  Annotations: paths, the instructions that describe them, and what they ask for. One model
/// for all benchmarks; the readers of their files are in the folder formats/ beside this one.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/goal.h"

namespace enfilade::tasks {

class ObjectBoxes;

/// Instructions of a path of R2R that are scored; a few paths have a fourth one, which is trained
/// on only. Other benchmarks score all.
inline constexpr std::size_t kScoredInstructions = 3;

/// A word of an instruction that was spoken, and when (RxR).
struct TimedWord {
  std::string word;
  std::optional<double> start, end;  ///< seconds since the recording began; some lack one or both
  friend bool operator==(const TimedWord&, const TimedWord&) = default;
};

/// One message of a dialogue (CVDN).
struct DialogueTurn {
  std::string role;  ///< "navigator" or "oracle"
  std::string message;
  std::int64_t nav_step = 0;  ///< `nav_idx`: number of steps before the message
  friend bool operator==(const DialogueTurn&, const DialogueTurn&) = default;
};

/// A piece of an instruction and the piece of the path that it describes (FGR2R).
struct SubInstruction {
  std::vector<std::string> words;
  /// Places on the path, 0-based, both included; the same twice for a piece without a move. No
  /// value in test splits.
  std::optional<std::pair<std::size_t, std::size_t>> places;
  friend bool operator==(const SubInstruction&, const SubInstruction&) = default;
};

/// Details of an instruction beside its text, as some benchmarks have them. All may be empty.
struct InstructionDetails {
  std::string id;                     ///< its `instr_id`; empty: the path's id, "_", k
  std::string language;               ///< BCP 47: "en-IN"
  std::vector<TimedWord> words;       ///< of the text
  std::vector<DialogueTurn> turns;    ///< before the navigator's next steps
  std::vector<SubInstruction> parts;  ///< in order
  std::vector<std::int32_t> tokens;   ///< `instr_encoding(s)`: ids of BERT's or XLM-R's vocabulary
  /// Parts by name, as SOON has them: obj_name, attribute, relation, region.
  std::vector<std::pair<std::string, std::string>> fields;
  /// SOON as released: the `instr_id` of its entry, by which submissions answer it: an entry's
  /// alternatives and instructions share it. No value: the file names no entries.
  std::optional<std::string> entry = {};
  friend bool operator==(const InstructionDetails&, const InstructionDetails&) = default;
};

/// A path as its file has it, with the instructions that describe it.
struct PathAnnotation {
  std::int64_t path_id = 0;
  std::string scan;
  Radians heading;                 ///< of the start, [0, 2 pi)
  std::vector<std::string> path;   ///< viewpoint ids; the start only if the goal is hidden
  std::optional<double> distance;  ///< length in metres; none if the goal is hidden
  std::vector<std::string> instructions;
  // In other benchmarks than R2R.
  std::string id = {};  ///< prefix of instruction ids: "1357_66"; empty: path_id
  NamedGoal goal = {};
  /// One per instruction, or empty.
  std::vector<InstructionDetails> details = {};
  /// Group of the bootstrap: paths with the same number are not independent samples, and are drawn
  /// as one. No value: this path is alone.
  std::optional<std::int64_t> group = {};

  bool goal_hidden() const noexcept {
    return std::holds_alternative<HiddenGoal>(goal) ||
           (std::holds_alternative<NearEnd>(goal) && path.size() < 2);
  }
  friend bool operator==(const PathAnnotation&, const PathAnnotation&) = default;
};

/// A whole file.
struct Annotations {
  std::string split;  ///< "train", "val_seen", ...
  std::string file;
  std::vector<PathAnnotation> paths;
  Task task = Task::kR2r;
};

/// Reads a file. `distance` may be absent. `instructions` may be empty: paths without instructions
/// yet, as `enfilade sample` writes them. Fields of other names are ignored.
/// \throws FileError
/// \throws InvalidInput listing its faults (up to 1000) with their JSON paths:
/// - not JSON; missing, repeated or wrongly typed fields
/// - bad ids (core/names.h), angles beyond kMostRadians (core/numbers.h)
/// - empty paths, negative distances and path_ids, repeated path_ids
Annotations load_annotations(const std::filesystem::path& file, std::string split);
Annotations parse_annotations(std::string_view json, const std::string& file, std::string split);

/// The file's content in R2R's format, one entry per line, which load_annotations() reads back
/// equal.
/// \throws ArgumentError for an infinite number or text that is not UTF-8, which JSON cannot
/// express
std::string to_json(const Annotations& annotations);

/// "<path_id>_<k>": the `instr_id` of instruction k of a path.
std::string instruction_id(std::int64_t path_id, std::size_t k);

/// A path whose names have been looked up.
struct ReferencePath {
  std::int64_t path_id = 0;
  ScanIndex scan;
  Radians heading;
  std::vector<ViewpointIndex> viewpoints;  ///< start to goal; the start only if the goal is hidden
  Goal goal = {};
  std::size_t group = 0;  ///< for the bootstrap; the same for paths that belong together
};

/// Whether the file hides the path's end, so that an agent can follow it, but not be scored.
bool goal_hidden(const ReferencePath& path) noexcept;

/// One instruction to follow: an agent's input, and the unit of scores.
struct Episode {
  std::string instruction_id;
  std::size_t path = 0;         ///< index into EpisodeSet::paths
  std::size_t instruction = 0;  ///< k, 0-based
  std::string text;
  InstructionDetails details = {};
};

/// Which instructions of a path become episodes.
enum class Instructions {
  kScored,  ///< R2R: the first kScoredInstructions; else all
  kAll,     ///< fourth ones too, for training
};

/// Which instructions of the split a results file has to answer.
enum class Coverage : std::uint8_t {
  kAll,   ///< a missing one is a fault
  kPart,  ///< at least one: a part of the split is looked at on purpose
};

/// The episodes of a split, with their graphs. Immutable: any thread.
struct EpisodeSet {
  std::string split;
  std::shared_ptr<const graph::GraphSet> graphs;
  std::vector<ReferencePath> paths;
  std::vector<Episode> episodes;  ///< in file order
  Task task = Task::kR2r;
  /// Object boxes (REVERIE); null if not loaded.
  std::shared_ptr<const ObjectBoxes> objects = {};

  /// The episode's reference path, and the graph of its scan. Valid as long as *this.
  const ReferencePath& path_of(const Episode& e) const { return paths[e.path]; }
  const graph::NavGraph& graph_of(const Episode& e) const { return graphs->graph(path_of(e).scan); }
};

/// Metres along the edges of a path. \pre graph is the path's, and look_up_paths() gave the path
double length_of(const ReferencePath& path, const graph::NavGraph& graph);

/// Looks up scans and viewpoints, of goals too, in the order of the file. Steps of R2R, R2R-Last,
/// R2R-Back, R4R and RxR must join adjacent viewpoints; other benchmarks have steps between any
/// two.
/// \throws InvalidInput listing, with JSON paths, every unknown scan, unknown or excluded
/// viewpoint, and step between viewpoints that are not adjacent
/// \throws FileError, InvalidInput for a graph's file
std::vector<ReferencePath> look_up_paths(const Annotations& annotations,
                                         const graph::GraphSet& graphs,
                                         const ObjectBoxes* objects = nullptr);

/// look_up_paths() and the instructions to follow.
/// \param objects  boxes of REVERIE's goals; without them no viewpoint sees the goal's object. They
/// are used in this call only: EpisodeSet::objects stays empty
/// \throws as look_up_paths(); InvalidInput also for each path without an instruction
EpisodeSet make_episodes(const Annotations& annotations,
                         std::shared_ptr<const graph::GraphSet> graphs,
                         Instructions instructions = Instructions::kScored,
                         const ObjectBoxes* objects = nullptr);

/// The `instr_id` of instruction k: as its file has it, else made of the path's id.
/// \pre k < path.instructions.size()
std::string instruction_id(const PathAnnotation& path, std::size_t k);

}  // namespace enfilade::tasks
