#include "apps/enfilade/drawn_path.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "enfilade/draw/planned_goal.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"

namespace enfilade::apps {
namespace {

// \param named the option and its value \param what for messages
template <class T, class Id>
std::size_t place_in(const std::vector<T>& all, const Id& id, Id T::*own, const std::string& named,
                     const char* what, const std::string& split) {
  const auto found = std::ranges::find(all, id, own);
  if (found != all.end()) return static_cast<std::size_t>(found - all.begin());
  throw LookupError(fmt::format("{}: not one of the {} {} of {}", named, all.size(), what, split));
}

}  // namespace

void add_scan_argument(CLI::App& verb, std::string& scan) {
  add_value(verb, "scan", scan, "SCAN", "Scan id; optional with --instr or --path");
}

void add_path_options(CLI::App& verb, PathOptions& options, const std::string& results_help) {
  add_value(verb, "--split", options.split, "NAME", "Split of --instr or --path");
  add_setting(verb, "--task", options.task, "NAME",
              "Benchmark of the split, whose goal is drawn: r2r, r2r-last, r2r-back, r4r, rxr, "
              "reverie, cvdn or soon");
  add_value(verb, "--instr,--instruction", options.instruction, "ID",
            "Draw the reference path of this instruction");
  add_value(verb, "--path", options.path, "PATH_ID", "Draw the reference path of this path_id");
  add_value(verb, "--results", options.results, "FILE",
            "Results file of the split: " + results_help);
}

void validate(const PathOptions& options, const std::string& scan) {
  const bool named = !options.instruction.empty() || options.path.has_value();
  if (scan.empty() && !named) {
    throw UsageError("name a SCAN, or a path of it with --split and --instr or --path");
  }
  if (!options.instruction.empty() && options.path) {
    throw UsageError("--instr and --path exclude each other");
  }
  if (named && options.split.empty()) throw UsageError("--instr and --path need --split");
  if (!named && !options.split.empty()) throw UsageError("--split needs --instr or --path");
  if (!options.results.empty() && options.instruction.empty()) {
    throw UsageError("--results needs --split and --instr: trajectories are of instructions");
  }
}

std::string DrawnPath::title() const {
  const std::string what = episode ? "instruction " + episodes.episodes[*episode].instruction_id
                                   : fmt::format("path {}", path().path_id);
  const std::string of =
      episodes.task == tasks::Task::kR2r
          ? episodes.split
          : fmt::format("{} {}", tasks::benchmark(episodes.task).title, episodes.split);
  return fmt::format("{}, {} of {}", graph().scan(), what, of);
}

std::vector<std::string> DrawnPath::lines() const {
  return episode ? draw::episode_lines(episodes.episodes[*episode]) : std::vector<std::string>();
}

std::string DrawnPath::goal_name() const {
  const tasks::Episode* shown = episode ? &episodes.episodes[*episode] : nullptr;
  for (std::size_t k = 0; shown == nullptr && k < episodes.episodes.size(); ++k) {
    if (episodes.episodes[k].path == place) shown = &episodes.episodes[k];
  }
  return shown == nullptr ? "" : draw::name_of_goal(episodes, *shown, objects());
}

DrawnPath find_path(const PathOptions& options, const std::string& scan,
                    const dataset::Dataset& data) {
  DrawnPath found;
  const tasks::Task task = tasks::benchmark(options.task, tasks::WorldKind::kGraph).task;
  found.episodes = data.episodes(task, options.split);
  const std::string& split = found.episodes.split;
  if (options.path) {
    found.place = place_in(found.episodes.paths, *options.path, &tasks::ReferencePath::path_id,
                           fmt::format("--path {}", *options.path), "paths", split);
  } else {
    found.episode =
        place_in(found.episodes.episodes, options.instruction, &tasks::Episode::instruction_id,
                 fmt::format("--instr {:?}", options.instruction), "scored instructions", split);
    found.place = found.episodes.episodes[*found.episode].path;
  }
  if (!scan.empty() && scan != found.graph().scan()) {
    throw UsageError(fmt::format("SCAN {}: that path is in {}", scan, found.graph().scan()));
  }
  if (!options.results.empty()) {
    tasks::Results results = tasks::load_results(options.results, found.episodes);
    found.walk = std::move(results.trajectories.at(*found.episode));
  }
  return found;
}

}  // namespace enfilade::apps
