// enfilade demo: the agents that learn nothing, beside the paper's; then, in model homes, those
// that do.
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "apps/common/program.h"
#include "apps/enfilade/home_pictures.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/run.h"
#include "enfilade/core/file.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/homes/building_plan.h"
#include "enfilade/report/results_table.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"
#include "enfilade/tasks/statistics.h"

namespace enfilade::apps::demo_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string data, output = "enfilade-demo";
  std::uint64_t seeds = 25;
  bool skip_learning = false, open = false;
};

// What the demo shows of a score: TL and NE in metres, SR and OSR in per cent.
constexpr std::size_t kColumns = 4;
using Row = std::array<double, kColumns>;

struct Measured {
  Row mean{};
  Row deviation{};  // of the seeds' means
};

Row row_of(const std::vector<tasks::EpisodeMetrics>& episodes) {
  Row row{};
  for (const tasks::EpisodeMetrics& m : episodes) {
    row[0] += m.trajectory_length;
    row[1] += m.nav_error;
    row[2] += 100 * m.success;
    row[3] += 100 * m.oracle_success;
  }
  for (double& value : row) value /= static_cast<double>(episodes.size());
  return row;
}

Measured measure(const std::vector<Row>& rows) {
  Measured measured;
  for (std::size_t k = 0; k < kColumns; ++k) {
    std::vector<double> values;
    for (const Row& row : rows) values.push_back(row[k]);
    const tasks::Summary summary = tasks::summarise(std::move(values));
    measured.mean[k] = summary.mean;
    measured.deviation[k] = summary.deviation;
  }
  return measured;
}

dataset::Dataset find_data(const Options& options) {
  if (!options.data.empty()) return dataset::Dataset(options.data);
  if (const auto named = dataset::Dataset::from_environment()) return *named;
  const fs::path folder = fs::path(options.output) / "homes";
  say("No real data: ENFILADE_DATA is not set. The 90 Matterport3D graphs are the folder\n"
      "connectivity/ of peteanderson80/Matterport3DSimulator on GitHub, and its\n"
      "tasks/R2R/data/download.sh fetches the Room-to-Room annotations. Put them into one folder\n"
      "and set ENFILADE_DATA to it.\n\n"
      "Until then: SYNTHETIC model homes, made now in {} (about two minutes on two\n"
      "cores; the next demo finds them there).\n\n",
      folder.string());
  std::fflush(stdout);
  homes::write_homes(folder, homes::home_set_preset("demo"), set_bar("model homes"));
  homes::write_home_paths(folder, {}, set_bar("instructions"));
  return dataset::Dataset(folder);
}

void print_dataset(const dataset::Dataset& data) {
  std::vector<tasks::Annotations> splits;
  for (const auto split : tasks::benchmark(tasks::Task::kR2r).splits)
    splits.push_back(data.annotations(split));
  const auto s = tasks::compute_statistics(splits, data.graphs());
  const bool synthetic = data.synthetic();
  struct Line {
    const char* what;
    double ours;
    const char* paper;  // its sections 4.1 to 4.3
    int digits;
  };
  const std::array<Line, 8> lines{
      {{"buildings", static_cast<double>(s.graphs.graphs), "90", 0},
       {"viewpoints a graph", s.graphs.viewpoints_per_graph, "117", 1},
       {"degree of a viewpoint", s.graphs.degree, "4.1", 2},
       {"paths", static_cast<double>(s.all.paths), "7,189", 0},
       {"scored instructions", static_cast<double>(s.all.scored_instructions), "21,567", 0},
       {"words an instruction", s.all.instruction_length.mean, "29", 1},
       {"vocabulary", static_cast<double>(s.all.vocabulary), "3.1k", 0},
       {"  of 5 or more uses", static_cast<double>(s.all.vocabulary_5), "1.2k", 0}}};
  say("The data set{}\n{:<24}{:>10}{}\n", synthetic ? " (SYNTHETIC)" : "", "", "ours",
      synthetic ? "" : fmt::format("{:>10}", "paper"));
  for (const Line& line : lines) {
    say("{:<24}{:>10.{}f}{}\n", line.what, line.ours, line.digits,
        synthetic ? "" : fmt::format("{:>10}", line.paper));
  }
  say("\n");
}

std::optional<Row> published(const std::string& agent, const std::string& split) {
  const auto row = report::published_row(agent, split);
  if (!row) return std::nullopt;
  return Row{row->trajectory_length, row->nav_error, 100 * row->success, 100 * row->oracle_success};
}

void print_row(const char* label, const std::string& who, const Row& row, const Row* deviation) {
  say("{:<12}{:<22}", label, who);
  for (std::size_t k = 0; k < kColumns; ++k) {
    const int digits = k < 2 ? 2 : 1;
    say("{:>8.{}f}{:<8}", row[k], digits,
        deviation == nullptr ? "" : fmt::format(" ±{:.{}f}", (*deviation)[k], digits));
  }
  say("\n");
}

void print_agent(const std::string& agent, const std::string& split, const Measured& ours,
                 std::uint64_t seeds, const std::optional<Row>& paper) {
  const bool varies = seeds > 1;
  print_row(split.c_str(), varies ? fmt::format("{}, {} seeds", agent, seeds) : agent, ours.mean,
            varies ? &ours.deviation : nullptr);
  if (!paper) return;
  print_row("", "  paper", *paper, nullptr);
  if (!varies) return;
  say("{:<12}{:<22}", "", "  paper is off by, sd");
  for (std::size_t k = 0; k < kColumns; ++k) {
    say("{:>8.1f}{:<8}", ((*paper)[k] - ours.mean[k]) / ours.deviation[k], "");
  }
  say("\n");
}

// A floor plan with the reference path and where the random agent went.
void draw_episode(const tasks::EpisodeSet& episodes, const tasks::Trajectory& trajectory,
                  const dataset::Dataset& data, const OutputFolder& out, const std::string& file) {
  const tasks::Episode& episode = episodes.episodes[trajectory.episode];
  draw::PlannedPath reference{draw::PathRole::kReference, episodes.path_of(episode).viewpoints,
                              "reference path"};
  draw::PlannedPath agent{draw::PathRole::kAgent, {}, "random agent"};
  for (const tasks::TrajectoryPoint& point : trajectory.points) {
    agent.viewpoints.push_back(point.viewpoint);
  }
  const graph::NavGraph& graph = episodes.graph_of(episode);
  draw::FloorPlanOptions options;
  options.title = fmt::format("{}, episode {}", graph.scan(), episode.instruction_id);
  options.note = episode.text;
  const homes::BuildingPlan plan =
      homes::read_building_plan(data.folder(), data.panorama_places().images, graph);
  options.underlay = plan.drawn();
  out.write(file, draw::floor_plan_svg(graph, {reference, agent}, options));
}

void run_agents(const Options& options, const dataset::Dataset& data, const std::string& split) {
  const tasks::EpisodeSet episodes = data.episodes(split);
  for (const std::string& name : {std::string("shortest"), std::string("random")}) {
    const auto agent = agents::make_agent(name);
    const std::uint64_t seeds = name == "random" ? options.seeds : 1;
    const Progress progress = progress_bar(fmt::format("{}, {}", name, split));
    std::vector<Row> rows;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      const auto trajectories = agents::run_agent(*agent, episodes, {.seed = seed});
      rows.push_back(row_of(tasks::score_trajectories(trajectories, episodes, {}, 0)));
      if (progress) progress(seed, seeds);
      if (seed > 1) continue;
      const OutputFolder out(options.output);
      out.write(fmt::format("{}_{}.json", name, split), to_json(trajectories, episodes));
      if (name == "random") {
        draw_episode(episodes, trajectories.front(), data, out, fmt::format("plan_{}.svg", split));
      }
    }
    print_agent(name, split, measure(rows), seeds,
                data.synthetic() ? std::nullopt : published(name, split));
  }
}

// As a reader can type it here: few have the program on their PATH.
std::string own_path() { return fs::proximate(own_program()).string(); }

void run_unlearned(const Options& options, const dataset::Dataset& data) {
  data.graphs()->load_all();
  print_dataset(data);
  say("Agents that learn nothing{}; ± is one standard deviation over seeds\n",
      data.synthetic() ? ", on SYNTHETIC buildings" : " (Anderson et al. 2018, table 1)");
  say("{:<12}{:<22}{:>8}{:<8}{:>8}{:<8}{:>8}{:<8}{:>8}\n", "split", "agent", "TL (m)", "", "NE (m)",
      "", "SR (%)", "", "OSR (%)");
  for (const char* split : {"val_seen", "val_unseen"}) run_agents(options, data, split);
  say("\nIn {0}: results files of both agents, to score with\n"
      "  {2} score {0}/random_val_unseen.json --split val_unseen --data {1}\n"
      "and two floor plans to look at: plan_val_seen.svg, plan_val_unseen.svg\n",
      options.output, data.folder().string(), own_path());
}

void draw_pictures(const Options& options, const dataset::Dataset& data) {
  say("Pictures of the homes, to look at:");
  for (const std::string& file : draw_homes(data.folder(), options.output)) {
    say(" {}", file);
  }
  say("\n");
}

std::string variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): never set here
  return value == nullptr ? "" : value;
}

// BROWSER may name several, with colons between them; xdg-open needs a display.
std::vector<std::string> browsers() {
  std::vector<std::string> names;
  for (const std::string& name : CLI::detail::split(variable("BROWSER"), ':')) {
    if (!name.empty()) names.push_back(name);
  }
  if (!variable("DISPLAY").empty() || !variable("WAYLAND_DISPLAY").empty()) {
    names.emplace_back("xdg-open");
  }
  return names;
}

// Its own session and no output, so that it outlives this program and does not write into it.
bool start_browser(const std::string& program, const std::string& file) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::string name = program, argument = file;
  std::array<char*, 3> arguments{name.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int failed =
      posix_spawnp(&child, program.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return failed == 0;
}

// Shows a file in the browser that BROWSER names, or in the desktop's (xdg-open). Does not wait for
// it. False if there is none, as in a container or over ssh.
bool open_page(const fs::path& file) {
  const std::string page = fs::absolute(file).string();
  for (const std::string& browser : browsers()) {
    if (start_browser(browser, page)) return true;
  }
  return false;
}

// What comes after the demo, for people who have data.
void print_next(const Options& options, bool learned) {
  if (learned) {
    const fs::path report = fs::absolute(fs::path(options.output) / "report.html");
    const bool opened = options.open && open_page(report);
    say("\nThe report, one page for any browser: {}\n{}", report.string(),
        opened ? "It was given to your browser.\n"
        : options.open
            ? "No browser was found here (BROWSER, or a desktop's): copy the page to one.\n"
            : "To see it at once: demo --open, or xdg-open and this name.\n");
  }
  say("\nNext, with Room-to-Room's own graphs and annotations (no licence form is needed):\n"
      "  {0} train --data DIR --inputs language --feedback teacher -o models/language\n"
      "and with Matterport3D's pictures, or anybody's feature file:\n"
      "  {0} features --data DIR --weights resnet152.pth -o features.safetensors\n"
      "  {0} train --data DIR --features features.safetensors -o models/student\n"
      "docs/neural.md goes through it from the download to the table.\n",
      own_path());
}

int demo(const Options& options) {
  make_folder(options.output);
  const dataset::Dataset data = find_data(options);
  run_unlearned(options, data);
  std::error_code code;
  const fs::path& root = data.folder();
  const bool homes = fs::exists(root / "homes.json", code) && fs::exists(root / "store", code);
  if (homes) draw_pictures(options, data);
  const bool learns = homes && !options.skip_learning && can_learn();
  if (homes && !options.skip_learning && !can_learn()) {
    say("\nNo agent is trained, as the program enfilade-learn is not here. {}\n", kHowToLearn);
  }
  const int status = learns ? learn_in_homes(root, options.output) : kSuccess;
  if (status == kSuccess) print_next(options, learns);
  return status;
}

}  // namespace

void add(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand(
      "demo", "Reproduce the paper's baselines; without data, make homes and train");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_setting(verb, "-o,--output", options->output, "DIR", "Output folder");
  add_whole_number(verb, "--seeds", options->seeds, "Number of seeds of the random agent");
  verb.add_flag("--skip-learning", options->skip_learning, "Train no agent");
  verb.add_flag("--open", options->open, "Show the report in the browser at the end");
  set_examples(verb,
               {"enfilade demo", "enfilade demo --open", "enfilade demo --skip-learning",
                "enfilade demo --data ~/data --seeds 100"},
               "An interrupted run resumes. Homes and their results are SYNTHETIC.");
  verb.callback([options, &status] { status = demo(*options); });
}

}  // namespace enfilade::apps::demo_verb
