/// \file  Shared by the verbs that draw a path: the choice of the path, and an agent's trajectory
/// on it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::apps {

/// Options that name a path.
struct PathOptions {
  std::string task = "r2r", split, instruction, results;
  std::optional<std::int64_t> path;
};
/// SCAN, which a path makes needless.
void add_scan_argument(CLI::App& verb, std::string& scan);
/// --task, --split, --instr (or --instruction), --path, --results; `results_help` describes the
/// drawing of a results file.
void add_path_options(CLI::App& verb, PathOptions& options, const std::string& results_help);
/// \throws UsageError if neither a scan nor a path is named, or options contradict each other
void validate(const PathOptions& options, const std::string& scan);

/// A path of a split, with its facts.
struct DrawnPath {
  tasks::EpisodeSet episodes;
  std::size_t place = 0;                  ///< in episodes.paths
  std::optional<std::size_t> episode;     ///< in episodes.episodes; for --instr
  std::optional<tasks::Trajectory> walk;  ///< for --results

  const tasks::ReferencePath& path() const { return episodes.paths[place]; }
  const graph::NavGraph& graph() const { return episodes.graphs->graph(path().scan); }
  std::string title() const;  ///< "17DRP5sb8fy, path 5 of test"
  /// The instruction's lines (draw::episode_lines()); empty without --instr.
  std::vector<std::string> lines() const;
  /// The goal's name (draw::name_of_goal()); may be empty.
  std::string goal_name() const;
  /// Object boxes (REVERIE); else null. Valid as long as *this.
  const tasks::ObjectBoxes* objects() const { return episodes.objects.get(); }
};
/// \param scan may be empty. \throws LookupError for an unknown task, or naming the option;
/// UsageError if the path is in another scan; as Dataset::episodes(), tasks::load_results()
DrawnPath find_path(const PathOptions& options, const std::string& scan,
                    const dataset::Dataset& data);

}  // namespace enfilade::apps
