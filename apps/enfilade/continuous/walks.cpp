// enfilade filmstrip: what an agent saw on a walk in the continuous world; enfilade top-down: a map
// of a floor, with walks on it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/mesh_files.h"
#include "apps/enfilade/picture_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/draw/contact_sheet.h"
#include "enfilade/draw/top_down.h"
#include "enfilade/tasks/continuous_results.h"

namespace enfilade::apps {
namespace {

// Which episode a verb draws.
struct EpisodeOptions {
  std::string episode, data, task = "r2r-ce", split = "val_unseen";
};

void add_split_options(CLI::App& verb, EpisodeOptions& options) {
  add_data_option(verb, options.data);
  add_setting(verb, "--task", options.task, "NAME", "Benchmark: r2r-ce or rxr-ce",
              CLI::IsMember({"r2r-ce", "rxr-ce"}));
  add_setting(verb, "--split", options.split, "NAME", "Split of the episode");
}

// Null if there is no such id. Valid as long as `episodes`.
const tasks::ContinuousEpisode* find_episode(const tasks::ContinuousEpisodes& episodes,
                                             const std::string& id) {
  for (const tasks::ContinuousEpisode& e : episodes.episodes) {
    if (tasks::text_of(e.id) == id) return &e;
  }
  return nullptr;
}

// The trajectory of one of `episodes` in a results file.
tasks::ContinuousResult walk_of(const std::string& results,
                                const tasks::ContinuousEpisodes& episodes,
                                const tasks::ContinuousEpisode& episode) {
  for (tasks::ContinuousResult& walk :
       tasks::load_continuous_results(results, episodes, tasks::Coverage::kPart)) {
    if (&episodes.episodes.at(walk.episode) == &episode) return std::move(walk);
  }
  throw UsageError(
      fmt::format("{}: has no walk of episode {}", results, tasks::text_of(episode.id)));
}

}  // namespace

namespace filmstrip_verb {
namespace {

struct Options : EpisodeOptions {
  std::string results, meshes;
  std::string output = "walk.jpg", thumb = "320x240", appearance = "mesh";
  double vfov = 63.4534;  // 79 degrees from left to right at 4 : 3
  std::size_t pictures = 12, columns = 0;
  int threads = 0;
};

// The expert's walk along the reference path.
tasks::ContinuousResult expert_walk(const tasks::ContinuousEpisodes& episodes,
                                    const tasks::ContinuousEpisode& episode,
                                    const std::shared_ptr<const continuous::Buildings>& buildings,
                                    const agents::ContinuousSetup& setup) {
  tasks::ContinuousEpisodes one = episodes;
  one.episodes = {episode};
  if (!episode.reference_path) {
    throw UsageError(
        fmt::format("episode {} of {} has no reference path for an expert; give --results FILE",
                    tasks::text_of(episode.id), episodes.split));
  }
  const auto expert = agents::make_continuous_agent("reference");
  return agents::run_continuous(*expert, one, buildings, {.simulator = setup.simulator}).front();
}

// "12: forward"; the last pose has no action after it.
std::string caption(const tasks::ContinuousResult& walk, std::size_t k) {
  constexpr std::array<std::string_view, 6> kNames{"stop",  "forward", "left",
                                                   "right", "up",      "down"};
  if (k >= walk.actions.size()) return fmt::format("{}", k);
  return fmt::format("{}: {}", k, kNames.at(walk.actions[k]));
}

// So many poses, evenly spread, the first and the one before the last action among them.
std::vector<std::size_t> chosen_poses(const tasks::ContinuousResult& walk, std::size_t count) {
  const std::size_t last = std::max<std::size_t>(walk.actions.size(), 1) - 1;
  if (last + 1 <= count) count = last + 1;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i) {
    chosen.push_back(count == 1 ? 0 : (i * last + (count - 1) / 2) / (count - 1));
  }
  return chosen;
}

std::vector<draw::SheetPicture> captioned_poses(const tasks::ContinuousResult& walk,
                                                const std::vector<std::size_t>& poses,
                                                const exports::BuildingLook& look,
                                                const Camera& camera, double eye_height,
                                                int threads) {
  continuous::Eyes eyes({look.scene}, {.threads = threads, .photographs = {look.photographs}});
  std::vector<draw::SheetPicture> pictures;
  for (image::Image8& drawn : exports::draw_poses(walk, poses, eyes, camera, eye_height)) {
    pictures.push_back({std::move(drawn), caption(walk, poses[pictures.size()])});
  }
  return pictures;
}

void draw_strip(const Options& options) {
  (void)picture_files({.file = options.output});  // throws if the name is not that of a picture
  const Size thumb = parse_size("--thumb", options.thumb);
  validate_field_of_view(options.vfov);
  const agents::ContinuousSetup& setup = agents::continuous_setup(options.task);
  const dataset::Dataset data = open_data(options.data);
  const tasks::Split split = data.split(*setup.benchmark, options.split, {.experts = false});
  const tasks::ContinuousEpisodes& episodes = *split.continuous();
  const tasks::ContinuousEpisode* episode = find_episode(episodes, options.episode);
  if (episode == nullptr) {
    throw UsageError(fmt::format("{}: no episode of {} {}", options.episode, setup.benchmark->name,
                                 options.split));
  }
  const tasks::ContinuousResult walk =
      options.results.empty()
          ? expert_walk(episodes, *episode, agents::open_buildings(*setup.benchmark, data.folder()),
                        setup)
          : walk_of(options.results, episodes, *episode);
  if (walk.headings.empty()) {
    throw UsageError(
        fmt::format("{}: results in RxR's form have no headings; write them with "
                    "`run --task r2r-ce`, or draw the expert's walk",
                    options.results));
  }
  const std::string scan(episode->scan());
  const exports::BuildingLook look =
      look_of_scan(data, {.folder = options.meshes}, scan,
                   find_enum<continuous::Appearance>(options.appearance).value(), options.threads);
  const auto pictures = captioned_poses(walk, chosen_poses(walk, options.pictures), look,
                                        {thumb.width, thumb.height, degrees(options.vfov)},
                                        setup.simulator.eye_height, options.threads);
  const std::string title =
      fmt::format("{}{}, episode {} of {}: {}", scan, data.synthetic() ? " (SYNTHETIC)" : "",
                  options.episode, options.split, episode->instruction.text);
  const image::Image8 sheet =
      draw::contact_sheet(pictures, {.columns = options.columns, .title = title});
  write_picture(options.output, encode(sheet, options.output));
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "filmstrip", "Draw the views of a continuous trajectory as small pictures");
  const auto options = std::make_shared<Options>();
  add_value(verb, "episode", options->episode, "EPISODE", "Id of the episode")->required();
  add_split_options(verb, *options);
  add_value(verb, "--results", options->results, "FILE",
            "Results file with the trajectory to draw (default: an expert's trajectory)");
  add_setting(verb, "-o,--output", options->output, "FILE",
              "PNG or JPEG file; - for standard output");
  add_whole_number(verb, "--pictures", options->pictures,
                   "Number of pictures, evenly spaced along the trajectory", 1)
      ->type_name("N");
  add_value(verb, "--columns", options->columns, "N", "Pictures per row (default: chosen to fit)")
      ->check(whole_number(1));
  add_setting(verb, "--thumb", options->thumb, "WxH", "Size of a picture, pixels");
  add_field_of_view_option(verb, options->vfov);
  add_appearance_option(verb, options->appearance);
  add_value(verb, "--meshes", options->meshes, "DIR",
            "Folder of meshes SCAN.glb, .obj or .ply, instead of the data set's");
  add_threads_option(verb, options->threads);
  set_examples(verb, {"enfilade filmstrip 12 --data homes --results walks.json -o walk.jpg",
                      "enfilade filmstrip 12 --data homes --pictures 24 --appearance panoramas"});
  verb.callback([options] { draw_strip(*options); });
}

}  // namespace filmstrip_verb

namespace top_down_verb {
namespace {

struct Options : EpisodeOptions {  // or a scan in place of an episode
  std::string output;
  std::vector<std::string> results;
};

std::vector<draw::WalkedLine> lines_of(const tasks::ContinuousEpisodes& episodes,
                                       const tasks::ContinuousEpisode& episode,
                                       const Options& options) {
  using Role = draw::PathRole;
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
  std::string scan = options.episode;
  draw::TopDownOptions map;
  std::vector<draw::WalkedLine> lines;
  if (!buildings.find(scan)) {
    const tasks::Split split = data.split(*setup.benchmark, options.split, {.experts = false});
    const tasks::ContinuousEpisodes& episodes = *split.continuous();
    const tasks::ContinuousEpisode* episode = find_episode(episodes, options.episode);
    if (episode == nullptr) {
      throw UsageError(
          fmt::format("{}: neither a scan with a navigation mesh nor an episode of {} {}",
                      options.episode, setup.benchmark->name, options.split));
    }
    scan = episode->scan();
    map.title = fmt::format("{}, episode {} of {}", scan, options.episode, options.split);
    map.note = episode->instruction.text;
    lines = lines_of(episodes, *episode, options);
  } else if (!options.results.empty()) {
    throw UsageError("--results: needs an episode, not a scan");
  } else {
    map.title = scan;
  }
  if (data.synthetic()) map.title += " (SYNTHETIC)";
  const std::string svg = top_down_svg(buildings.floor(buildings.at(scan)).polygons(), lines, map);
  write_output(options.output, svg);
  if (options.output != "-") say("{}\n", options.output);
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb =
      *app.add_subcommand("top-down", "Draw a floor from above, with continuous trajectories");
  const auto options = std::make_shared<Options>();
  add_value(verb, "what", options->episode, "EPISODE|SCAN", "Id of an episode, or a scan")
      ->required();
  add_split_options(verb, *options);
  add_value(verb, "--results", options->results, "FILE...",
            "Results files with the trajectories to draw");
  add_value(verb, "-o,--output", options->output, "FILE.svg", "File, - for standard output")
      ->required();
  set_examples(verb, {"enfilade top-down 12 --data homes --results walks.json -o walk.svg",
                      "enfilade top-down home0001 --data homes -o floor.svg"});
  verb.callback([options] { draw_map(*options); });
}

}  // namespace top_down_verb

}  // namespace enfilade::apps
