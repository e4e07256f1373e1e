// enfilade top-down: a map of a floor, with walks on it.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "apps/common/program.h"
#include "apps/enfilade/continuous/walked_episode.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/draw/top_down.h"
#include "enfilade/tasks/continuous_results.h"

namespace enfilade::apps {
namespace top_down_verb {
namespace {

struct Options {
  std::string what, data, task = "r2r-ce", split = "val_unseen", output;
  std::vector<std::string> results;
};

std::vector<draw::WalkedLine> lines_of(const tasks::ContinuousEpisodes& episodes,
                                       const tasks::ContinuousEpisode& episode,
                                       const Options& options) {
  using Role = draw::WalkedLine::Role;
  std::vector<draw::WalkedLine> lines;
  if (episode.reference_path) lines.push_back({Role::kReference, *episode.reference_path, ""});
  for (const std::string& file : options.results) {
    const tasks::ContinuousResult walk = walk_of(file, episodes, episode);
    lines.push_back({Role::kAgent, draw::walked_points(walk.positions),
                     std::filesystem::path(file).stem().string()});
  }
  return lines;
}

void draw_map(const Options& options) {
  const agents::ContinuousSetup& setup = agents::continuous_setup(options.task);
  const dataset::Dataset data = open_data(options.data);
  const continuous::Buildings buildings(data.folder() / setup.navigation_folder());
  std::string scan = options.what;
  draw::TopDownOptions map;
  std::vector<draw::WalkedLine> lines;
  if (!buildings.find(scan)) {
    const tasks::ContinuousEpisodes episodes =
        agents::load_continuous_split(*setup.benchmark, data.folder(), options.split);
    const tasks::ContinuousEpisode* episode = find_episode(episodes, options.what);
    if (episode == nullptr) {
      throw UsageError(
          fmt::format("{}: neither a scan with a navigation mesh nor an episode of {} {}",
                      options.what, setup.benchmark->name, options.split));
    }
    scan = episode->scan();
    map.title = fmt::format("{}, episode {} of {}", scan, options.what, options.split);
    map.note = episode->instruction.text;
    lines = lines_of(episodes, *episode, options);
  } else if (!options.results.empty()) {
    throw UsageError("--results: needs an episode, not a scan");
  } else {
    map.title = scan;
  }
  if (data.synthetic()) map.title += " (SYNTHETIC)";
  const std::string svg = top_down_svg(buildings.floor(buildings.at(scan)).floor(), lines, map);
  write_output(options.output, svg);
  if (options.output != "-") fmt::print("{}\n", options.output);
}

void add_verb(CLI::App& app, int& /*status*/) {
  CLI::App& verb =
      *app.add_subcommand("top-down", "Draw a floor from above, with continuous trajectories");
  const auto options = std::make_shared<Options>();
  add_value(verb, "what", options->what, "EPISODE|SCAN", "Id of an episode, or a scan")->required();
  add_data_option(verb, options->data);
  add_setting(verb, "--task", options->task, "NAME", "Benchmark: r2r-ce or rxr-ce",
              CLI::IsMember({"r2r-ce", "rxr-ce"}));
  add_setting(verb, "--split", options->split, "NAME", "Split of the episode");
  add_value(verb, "--results", options->results, "FILE...",
            "Results files with the trajectories to draw");
  add_value(verb, "-o,--output", options->output, "FILE.svg", "File, - for standard output")
      ->required();
  set_examples(verb, {"enfilade top-down 12 --data homes --results walks.json -o walk.svg",
                      "enfilade top-down home0001 --data homes -o floor.svg"});
  verb.callback([options] { draw_map(*options); });
}

}  // namespace
}  // namespace top_down_verb

void add_top_down(CLI::App& app, int& status) { top_down_verb::add_verb(app, status); }

}  // namespace enfilade::apps
