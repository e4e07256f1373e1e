// enfilade filmstrip: what an agent saw on a walk in the continuous world.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/continuous/scenes.h"
#include "apps/enfilade/continuous/walked_episode.h"
#include "apps/enfilade/picture_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/continuous_run.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/draw/contact_sheet.h"

namespace enfilade::apps {
namespace filmstrip_verb {
namespace {

struct Options {
  std::string episode, data, task = "r2r-ce", split = "val_unseen", results, meshes;
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
        fmt::format("episode {} of {} has no reference path for an expert; give "
                    "--results FILE",
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
  const tasks::ContinuousEpisodes episodes =
      agents::load_continuous_split(*setup.benchmark, data.folder(), options.split);
  const tasks::ContinuousEpisode* episode = find_episode(episodes, options.episode);
  if (episode == nullptr) {
    throw UsageError(fmt::format("{}: no episode of {} {}", options.episode, setup.benchmark->name,
                                 options.split));
  }
  const tasks::ContinuousResult walk =
      options.results.empty() ? expert_walk(episodes, *episode,
                                            std::make_shared<const continuous::Buildings>(
                                                data.folder() / setup.navigation_folder()),
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
      look_of_scan(data, {.folder = options.meshes, .up = "format"}, scan,
                   continuous::parse_appearance(options.appearance).value(), options.threads);
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

void add_verb(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "filmstrip", "Draw the views of a continuous trajectory as small pictures");
  const auto options = std::make_shared<Options>();
  add_value(verb, "episode", options->episode, "EPISODE", "Id of the episode")->required();
  add_data_option(verb, options->data);
  add_setting(verb, "--task", options->task, "NAME", "Benchmark: r2r-ce or rxr-ce",
              CLI::IsMember({"r2r-ce", "rxr-ce"}));
  add_setting(verb, "--split", options->split, "NAME", "Split of the episode");
  add_value(verb, "--results", options->results, "FILE",
            "Results file with the trajectory to draw (default: an expert's trajectory)");
  add_setting(verb, "-o,--output", options->output, "FILE",
              "PNG or JPEG file; - for standard output");
  add_whole_number(verb, "--pictures", options->pictures,
                   "Number of pictures, evenly spaced "
                   "along the trajectory",
                   1)
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

}  // namespace
}  // namespace filmstrip_verb

void add_filmstrip(CLI::App& app, int& status) { filmstrip_verb::add_verb(app, status); }

}  // namespace enfilade::apps
