/// \file  The benchmarks of both worlds: a table with one row per benchmark. Whatever differs
/// between two of them and is no code is a field of the row.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/tasks/goal.h"
#include "enfilade/tasks/scorer.h"

namespace enfilade::tasks {

enum class ContinuousForm : std::uint8_t;

/// Where agents move: from viewpoint to viewpoint of a graph, or over a floor.
enum class WorldKind : std::uint8_t { kGraph, kContinuous };

/// What an episode asks for: the alternatives of NamedGoal, and a point on a floor.
enum class GoalKind : std::uint8_t { kNearEnd, kTurningPoint, kObject, kRegion, kBoxes, kPoint };

/// What results carry beside the path: Trajectory::turning_point, ::object or ::point.
enum class AnswerKind : std::uint8_t { kNone, kTurningPoint, kObject, kPoint };

/// Files of one kind that a benchmark has, relative to a folder of data. `{}` stands for the split.
struct FilePlaces {
  std::string_view kind;  ///< "guide", "follower"; "bertidx"; empty: the only or usual kind
  /// In the order in which they are looked for: Enfilade's layout, then those of the public code.
  /// Continuous: folders of the public code, which have a folder of each split.
  std::span<const std::string_view> places;
  std::string_view name = {};  ///< continuous: of the files; "_gt" ends the experts'
  bool experts = true;         ///< continuous: its own experts' walks; else those of the usual kind
};

/// A benchmark. Spans and names are of static storage.
struct Benchmark {
  std::string_view name;   ///< in commands and files: "r2r-ce"
  std::string_view title;  ///< for people: "R2R-CE"
  WorldKind world = WorldKind::kGraph;
  Task task = Task::kR2r;   ///< graph: its own; continuous: the one whose paths it follows
  Task paths = Task::kR2r;  ///< whose paths its own were made from: equal paths tell equal goals
  GoalKind goal = GoalKind::kNearEnd;
  AnswerKind answer = AnswerKind::kNone;
  bool joins_paths = false;     ///< each path joins two of `paths`: any two viewpoints tell of one
  bool starts_between = false;  ///< later episodes of a group start on the way to its goal
  /// The splits that its public files have, in their order. Any other name may be asked for, too.
  std::span<const std::string_view> splits;
  /// What files call the split "test"; empty: "test". Both names find it.
  std::string_view test_file = {};
  std::span<const FilePlaces> files;   ///< the usual kind first
  std::span<const Scorer> scorers;     ///< the default first
  std::string_view table_scorer = {};  ///< behind the columns of its table (report/)
  /// Graph: steps of a path join adjacent viewpoints. CVDN and SOON do not ask for it.
  bool along_edges = true;
  std::size_t scored_instructions = 0;  ///< per path; 0: all
  /// Where results of splits with hidden goals are handed in, a sentence; empty: nowhere.
  std::string_view leaderboard = {};
  bool languages = false;    ///< instructions have one, and tables a row for each
  bool in_paper = false;     ///< Anderson et al., CVPR 2018, table 1 has its rows
  ContinuousForm form = {};  ///< continuous: in which results are written

  constexpr bool continuous() const noexcept { return world == WorldKind::kContinuous; }
  /// By name; the default where it is empty. \throws LookupError listing the names
  const Scorer& scorer(std::string_view scorer_name) const;
  /// By which leaderboards rank: the first column of the default scorer. A share, or metres of
  /// progress; better where higher.
  constexpr const Measure& headline() const noexcept { return scorers.front().columns.front(); }
};

/// All: those on graphs in the order of Task, then those in continuous space.
std::span<const Benchmark> benchmarks() noexcept;
/// By name; null if there is none.
const Benchmark* find_benchmark(std::string_view name) noexcept;
/// By name. \throws LookupError listing the names
const Benchmark& benchmark(std::string_view name);
/// By name, of one world only. \throws LookupError listing the names of that world
const Benchmark& benchmark(std::string_view name, WorldKind world);
/// The benchmark on graphs.
const Benchmark& benchmark(Task task) noexcept;

/// The one name of a split: "test" for CVDN's "test_cleaned"; any other name is its own.
inline std::string_view split_name(const Benchmark& benchmark, std::string_view name) noexcept {
  return !name.empty() && name == benchmark.test_file ? "test" : name;
}

/// Where a split's episodes may be in a folder of data, relative to it, in the order in which they
/// are looked for. Each is looked for packed (".gz") and plain. For "test" the places of
/// Benchmark::test_file follow.
/// \param kind  of FilePlaces; empty: the usual one \throws LookupError for another
std::vector<std::filesystem::path> episode_places(const Benchmark& benchmark,
                                                  std::string_view split,
                                                  std::string_view kind = {});
/// The same of the experts' walks; empty for benchmarks on graphs.
std::vector<std::filesystem::path> expert_places(const Benchmark& benchmark, std::string_view split,
                                                 std::string_view kind = {});

}  // namespace enfilade::tasks
