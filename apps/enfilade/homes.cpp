// enfilade homes, its short form enfilade synth, and enfilade dataset: data sets of model homes.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/home_habitat.h"
#include "apps/enfilade/home_pictures.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/homes/home_set.h"

namespace enfilade::apps::homes_verb {
namespace {

// The part that is none of Matterport3D's.
constexpr const char* kHabitat = "habitat";

struct Options {
  std::string output, preset = "pretty", kind, corrections, shard, light;
  std::optional<std::size_t> homes, pretty;
  std::optional<std::uint64_t> seed;
  std::optional<std::uint32_t> size, samples, enlarge;
  std::vector<std::string> parts;
  std::uint32_t image_width = homes::HomeSetOptions().image_width;
  std::optional<double> area;
  std::size_t paths = homes::HomePathOptions().per_home;
  std::vector<std::string> tasks = homes::home_tasks();
  int threads = 0;
};

homes::HomeSetOptions set_of(const Options& o) {
  homes::HomeSetOptions set = homes::home_set_preset(o.preset);
  if (o.homes) set.homes = *o.homes;
  if (o.seed) set.seed = *o.seed;
  if (!o.kind.empty()) set.kind = find_enum<homes::HomeKind>(o.kind);
  if (o.area) {
    set.least_area = set.most_area = *o.area;
    set.stairs_every = 0;
  }
  if (o.size) set.face_size = *o.size;
  if (o.samples) set.samples = *o.samples;
  if (o.pretty) set.pretty = *o.pretty;
  if (!o.light.empty()) set.light = homes::parse_home_light(o.light);
  std::vector<std::string> of_scans = o.parts;
  std::erase(of_scans, kHabitat);
  set.parts = capture::scan_parts(of_scans);
  set.image_width = o.image_width;
  set.corrections = o.corrections;
  set.shard = parse_shard(o.shard);
  set.threads = o.threads;
  return set;
}

void print_homes(const std::vector<homes::HomeEntry>& homes) {
  say("{:<12}{:<8}{:>7}{:>12}{:>8}{:>11}\n", "SYNTHETIC", "kind", "rooms", "viewpoints", "edges",
      "triangles");
  std::array<std::size_t, 3> sums{};
  for (const homes::HomeEntry& home : homes) {
    say("{:<12}{:<8}{:>7}{:>12}{:>8}{:>11}\n", home.scan, home.kind, home.rooms.size(),
        home.viewpoints, home.edges, home.triangles);
    sums[0] += home.rooms.size();
    sums[1] += home.viewpoints;
    sums[2] += home.edges;
  }
  say("{:<12}{:<8}{:>7}{:>12}{:>8}\n", fmt::format("{} homes", homes.size()), "", sums[0], sums[1],
      sums[2]);
}

// "all" is what the program itself takes.
constexpr const char* kAllTasks = "all";
std::vector<std::string> tasks_of(const std::vector<std::string>& named) {
  return std::ranges::find(named, kAllTasks) == named.end() ? named : homes::home_tasks();
}

void enlarge(const Options& options) {
  const std::vector<std::string> scans = homes::enlarge_pictures(
      options.output, *options.enlarge, options.threads, set_bar("larger pictures"));
  if (scans.empty()) {
    say("{}: no home has smaller faces than {} texels\n", options.output, *options.enlarge);
  } else {
    say("{}: faces of {} texels now\n", fmt::join(scans, ", "), *options.enlarge);
  }
}

// \returns whether paths were drawn
bool make_paths_of(const Options& options, std::size_t homes) {
  if (options.paths == 0) return false;
  if (homes < homes::kLeastHomes) {
    say("no paths: splits by building need {} homes, these are {}\n", homes::kLeastHomes, homes);
    return false;
  }
  homes::HomePathOptions paths{
      .per_home = options.paths, .tasks = tasks_of(options.tasks), .threads = options.threads};
  if (options.seed) paths.seed = *options.seed;
  const auto report = homes::write_home_paths(options.output, paths, set_bar("paths"));
  say("{} paths, {} instructions, all SYNTHETIC\n", report.paths, report.instructions);
  return true;
}

void make(const Options& options) {
  if (options.enlarge) return enlarge(options);
  const homes::HomeSetOptions set = set_of(options);
  const auto [homes, notes] = homes::write_homes(options.output, set, set_bar("homes"));
  print_homes(homes);
  if (!notes.empty()) print_diagnostics(notes);
  HabitatHomesOptions habitat{.episodes = false,
                              .per_home = options.paths,
                              .image_width = set.image_width,
                              .threads = set.threads};
  if (options.seed) habitat.seed = *options.seed;
  const bool for_habitat = std::ranges::find(options.parts, kHabitat) != options.parts.end();
  if (set.shard.count > 1) {
    if (for_habitat) write_habitat_homes(options.output, homes, habitat);
    say("share {} of the set; run without --shard when all shares are made\n", options.shard);
    return;
  }
  habitat.episodes = make_paths_of(options, homes.size());
  if (for_habitat) write_habitat_homes(options.output, homes, habitat);
}

void add_tasks_option(CLI::App& verb, std::vector<std::string>& tasks) {
  std::vector<std::string> known = homes::home_tasks();
  known.emplace_back("r2r");  // which is always written
  known.emplace_back(kAllTasks);
  add_value(verb, "--tasks", tasks, "TASK,...",
            "Benchmarks beside R2R, comma-separated; all, or r2r: none (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(known));
}

// The other options say how homes are made: these are made already.
void check_enlarge(const CLI::App& verb) {
  for (const CLI::Option* option : verb.get_options()) {
    const std::string name = option->get_name();
    const bool may = name == "--enlarge" || name == "--output" || name == "--threads";
    if (option->count() > 0 && !may) {
      throw UsageError(fmt::format(
          "--enlarge: with {}; the options of the homes in DIR stay, so only --threads may be "
          "given beside it",
          name));
    }
  }
}

struct DatasetOptions {
  std::string folder;
  homes::HomePathOptions paths;
};

void make_paths(const DatasetOptions& options) {
  homes::HomePathOptions paths = options.paths;
  paths.tasks = tasks_of(paths.tasks);
  const auto report = homes::write_home_paths(options.folder, paths, set_bar("paths"));
  say("{0}/r2r: {1} paths, {2} instructions, all SYNTHETIC; whole test paths in {0}/hidden\n",
      options.folder, report.paths, report.instructions);
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb =
      *app.add_subcommand("homes", "Make synthetic homes with panoramas, graphs and instructions");
  const auto options = std::make_shared<Options>();
  add_value(verb, "-o,--output", options->output, "DIR",
            "A new or empty folder, or one to complete")
      ->required();
  add_setting(verb, "--preset", options->preset, "",
              "Number and quality of the homes (docs/homes.md)",
              CLI::IsMember(homes::home_set_presets()));
  add_value(verb, "--homes", options->homes, "N", "Number of homes, instead of the preset's")
      ->check(whole_number(1, 10000));
  verb.add_option("--kind", options->kind, "Kind of building (default: a mixture)")
      ->check(CLI::IsMember(enum_names<homes::HomeKind>()));
  verb.add_option("--area", options->area,
                  "Floor area per home, all storeys, square metres, 60 to 3000")
      ->check(finite_number(homes::kLeastArea, homes::kMostArea));
  verb.add_option("--size", options->size, "Texels along a face's edge; 0: no pictures")
      ->check(whole_number(0, 4096));
  verb.add_option("--samples", options->samples, "Colour rays per texel: 1, 4, 9 or 16")
      ->check(whole_number(1));
  verb.add_option("--light", options->light, "fine, or coarse: a quarter of the time, for training")
      ->check(CLI::IsMember(enum_names<homes::HomeLight>()));
  verb.add_option("--pretty", options->pretty,
                  "Number of homes with fine light and 256-texel faces, val_unseen first")
      ->check(whole_number(0, 10000));
  verb.add_option("--seed", options->seed, "The same seed gives the same bytes")
      ->check(whole_number());
  std::vector<std::string> parts = capture::scan_part_names();
  parts.emplace_back(kHabitat);
  add_value(verb, "--parts", options->parts, "PART,...",
            "Matterport3D's files too, as of scan-mesh; habitat: scenes, floors, episodes")
      ->delimiter(',')
      ->check(CLI::IsMember(parts));
  add_setting(verb, "--image-width", options->image_width, "",
              "Width of undistorted images, pixels; the height is 4/5 of it",
              whole_number(10, 4096));
  add_value(verb, "--corrections", options->corrections, "DIR",
            "Folder of corrections of graphs, SCAN_corrections.json: docs/graph.md");
  add_value(verb, "--shard", options->shard, "K/N",
            "Make shard K of N only; then run once without it");
  add_whole_number(verb, "--paths", options->paths,
                   "Most R2R paths, and Habitat's episodes, per home; 0: none", 0);
  add_tasks_option(verb, options->tasks);
  add_value(verb, "--enlarge", options->enlarge, "N",
            "Replace pictures of the homes there by faces of N texels")
      ->check(whole_number(1, 4096));
  add_threads_option(verb, options->threads);
  set_examples(verb,
               {"enfilade homes -o homes", "enfilade homes -o two --preset small --paths 0",
                "enfilade homes -o homes --corrections homes-corrections",
                "enfilade homes -o homes --preset full --shard 3/16",
                "enfilade homes -o homes --size 0 --tasks r2r --parts habitat",
                "enfilade homes -o many --preset training --homes 300 --pretty 4",
                "enfilade homes -o homes --enlarge 1024",
                "enfilade contact-sheet home0001 --data homes -o home.png",
                "enfilade graph draw home0001 --data homes -o plan.svg"},
               "An interrupted run resumes. All output is synthetic, and says so.");
  verb.callback([&verb, options] {
    if (options->enlarge) check_enlarge(verb);
    make(*options);
  });
}

void add_synth(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "synth", "Make SYNTHETIC homes without pictures: short for homes --preset graphs");
  const auto options = std::make_shared<Options>();
  options->preset = "graphs";
  options->homes = homes::home_set_preset(options->preset).homes;
  options->seed = homes::HomeSetOptions().seed;
  add_value(verb, "-o,--output", options->output, "DIR",
            "A new or empty folder, or one to complete")
      ->required();
  add_setting(verb, "--buildings", options->homes, "N",
              "Number of homes, at least 3, one per split",
              whole_number(homes::kLeastHomes, 10000));
  add_whole_number(verb, "--seed", options->seed, "The same seed gives the same bytes", 0);
  set_examples(verb, {"enfilade synth -o my-data", "enfilade stats --data my-data",
                      "enfilade graph draw home0001 --data my-data -o plan.svg"});
  verb.callback([options] {
    make(*options);
    say("Use them with --data {} or ENFILADE_DATA; numbers from them compare with no others.\n",
        options->output);
  });
}

void add_dataset(CLI::App& app, int& /*status*/) {
  CLI::App& verb =
      *app.add_subcommand("dataset", "Make paths, instructions and splits for a folder of homes");
  const auto options = std::make_shared<DatasetOptions>();
  add_value(verb, "folder", options->folder, "DIR", "Folder that enfilade homes made")->required();
  add_whole_number(verb, "--paths", options->paths.per_home, "Most paths per home");
  add_whole_number(verb, "--seed", options->paths.seed, "The same seed gives the same bytes", 0);
  add_setting(verb, "--val-seen", options->paths.val_seen_share, "",
              "Share of the training homes' paths, 0 to 1", finite_number(0, 0.99));
  add_tasks_option(verb, options->paths.tasks);
  add_threads_option(verb, options->paths.threads);
  set_examples(verb,
               {"enfilade homes -o homes --paths 0", "enfilade dataset homes --paths 100",
                "enfilade dataset homes --tasks reverie,soon", "enfilade stats --data homes"});
  verb.callback([options] { make_paths(*options); });
}

}  // namespace enfilade::apps::homes_verb
