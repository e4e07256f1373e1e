/// \file  Phases of an evaluation: the splits that submissions are scored on.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/split.h"

namespace enfilade::service {

/// Which scores of a phase teams and visitors see. Organisers always see all of them. Every score
/// on secret goals gives something of them away. So kPublic is for open goals only; kAfterEnd and
/// kLadder are for secret goals only, and evaluation/leakage.h computes how much they give away.
enum class Scores : std::uint8_t {
  kPublic,    ///< everything, at once
  kAfterEnd,  ///< nothing until the phase's end; then one row of rounded means per team.
  /// The Ladder (Blum and Hardt, ICML 2015): a team's primary metric, rounded to Phase::step,
  /// whenever it beats its best shown one by at least a step. After the end as kAfterEnd.
  kLadder,
  kHidden,  ///< nothing, ever
};
constexpr std::array<std::string_view, 4> names_of(Scores /*enum*/) {
  return {"public", "after-end", "ladder", "hidden"};
}

/// A split to score on, and its rules. The limits count submissions that were accepted, withdrawn
/// ones too.
struct Phase {
  std::string name;   ///< 1 to 40 of a-z, 0-9, - and _, the first not -: a part of URLs
  std::string title;  ///< for people
  std::string rules;  ///< for people, in Markdown: rules, dates, whom to ask; may be empty
  std::string split;  ///< "val_unseen"; its instructions are served without their goals if secret
  /// Which benchmark the split is of. Never null.
  const tasks::Benchmark* benchmark = &tasks::benchmark(tasks::Task::kR2r);
  const tasks::Scorer* scorer = &benchmark->scorers.front();  ///< one of the benchmark's
  /// The name of the measure that decides which submission of a team is its best. Rows are sorted
  /// by it. It is a column of the scorer, better where higher.
  std::string primary = "spl";
  /// The task's annotations with goals, kept outside the data set, which everyone can download.
  /// Empty: the data set's own annotations, with open goals.
  std::filesystem::path annotations;
  /// The experts' trajectories (`<split>_gt.json.gz`) of a continuous split with secret goals, as
  /// references of nDTW. Empty: the reference paths.
  std::filesystem::path experts;
  Scores scores = Scores::kPublic;
  int per_day = 10;                ///< per team in 24 hours, 1 to 1000
  int per_address_day = 50;        ///< per address in 24 hours, by all its teams
  std::optional<int> per_team;     ///< per team in all; no value: no limit
  std::optional<int> per_address;  ///< per address in all; no value: no limit
  /// Seconds since 1970, after which no submission is taken; no value: open until the file has one.
  std::optional<std::int64_t> ends;
  /// Secret goals: shares are shown as multiples of it, metres as multiples of ten times it.
  double step = 0.01;
  int teams = 20;  ///< secret goals: number of teams that may submit

  bool goals_secret() const noexcept { return !annotations.empty(); }
  /// The columns of its leaderboard.
  std::span<const tasks::Measure> measures() const noexcept { return scorer->columns; }
  /// The measure that `primary` names. \pre it is one of measures()
  const tasks::Measure& primary_measure() const;
};

/// Whether two benchmarks have the same paths in splits of one name, so that goals of one reveal
/// those of the other. R2R and the benchmarks made from it do (R2R-Last, R2R-Back, R4R, REVERIE,
/// R2R-CE), and so do RxR and RxR-CE. Any other benchmark shares paths with itself only.
inline bool share_paths(const tasks::Benchmark& one, const tasks::Benchmark& other) noexcept {
  return one.paths == other.paths;
}
/// The first phase with secret goals that the benchmark's split of that name would reveal: both
/// have the same paths. Null: there is none.
const Phase* find_secret(std::span<const Phase> phases, std::string_view split,
                         const tasks::Benchmark& benchmark) noexcept;

/// Compares the episodes of a phase with secret goals with those of the split's public file, from
/// which teams get starts and instructions. Open goals: does nothing.
/// \param goals  the phase's episodes
/// \throws InvalidInput "no-public-file"; "ids-differ" with the first ids that one of them lacks;
/// as Dataset::split()
void check_public_file(const Phase& phase, const tasks::Split& goals, const dataset::Dataset& data);

/// Reads {"phases": [{"name", "split", ...}]}; docs/service_evaluation.md has the fields and their
/// defaults, of which some depend on whether the goals are secret. A relative path of annotations
/// begins at the file's folder, and so does one of experts. The split has the name that
/// tasks::split_name() gives.
/// \throws FileError; InvalidInput listing its faults (up to 1000) with their JSON paths; fields of
/// other names and more than 100 phases are faults
std::vector<Phase> load_phases(const std::filesystem::path& file);
std::vector<Phase> parse_phases(std::string_view json, const std::string& file);

}  // namespace enfilade::service
