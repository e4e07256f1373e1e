// enfilade continuous: navigation meshes and continuous episodes.
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/continuous/floors.h"
#include "apps/enfilade/continuous/scenes.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/mesh_floor.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/derive_continuous.h"

namespace enfilade::apps {
namespace continuous_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string data, task = "r2r-ce", headings = "path", dropped;
  MeshSource meshes;
  std::uint64_t seed = 1;
  int threads = 0;
  bool floors_only = false, light = false;
};

// What became of one split.
struct SplitReport {
  std::size_t episodes = 0, paths = 0;
  std::vector<tasks::DroppedPath> dropped;
};

std::size_t source_paths(const tasks::DerivedEpisodes& derived, const tasks::Annotations& from) {
  return from.paths.size() - derived.dropped.size();
}

void write_packed(const fs::path& file, const std::string& text) {
  make_folder(file.parent_path());
  write_file_atomically(file, gzip(text, 6));
}

tasks::Annotations annotations_of(const dataset::Dataset& data, tasks::ContinuousForm form,
                                  const std::string& split) {
  return form == tasks::ContinuousForm::kRxr ? data.annotations(tasks::Task::kRxr, split)
                                             : data.annotations(split);
}

SplitReport derive_split(const dataset::Dataset& data, const agents::ContinuousSetup& setup,
                         const std::shared_ptr<const continuous::Buildings>& buildings,
                         const std::string& split, const Options& options) {
  const tasks::Annotations annotations = annotations_of(data, setup.benchmark->form, split);
  tasks::DeriveOptions derive;
  derive.seed = options.seed;
  if (options.headings == "random") derive.start_headings = tasks::StartHeadings::kRandom;
  const tasks::DerivedEpisodes derived =
      tasks::derive_continuous(annotations, *data.graphs(), agents::MeshFloor(buildings), derive);
  const fs::path folder = data.folder();
  if (!goals_hidden(derived.episodes)) {
    const agents::ContinuousRunOptions run{
        .batch_size = 64, .seed = 1, .simulator = setup.simulator};
    write_packed(folder / tasks::expert_places(*setup.benchmark, split).front(),
                 to_json(agents::record_experts(derived.episodes, buildings, run,
                                                progress_bar("experts, " + split))));
  }
  write_packed(folder / tasks::episode_places(*setup.benchmark, split).front(),
               to_json(derived.episodes));
  return {derived.episodes.episodes.size(), source_paths(derived, annotations), derived.dropped};
}

void tell_dropped(const std::string& split, const SplitReport& report, std::string& text) {
  for (const tasks::DroppedPath& path : report.dropped) {
    text += fmt::format("{}\t{}\t{}\t{}\n", split, path.id, path.scan, path.why);
  }
}

FloorsReport make_and_tell(const dataset::Dataset& data, const agents::ContinuousSetup& setup,
                           const Options& options) {
  FloorsReport report = make_floors(data, setup, options.meshes, options.threads);
  const fs::path folder = data.folder() / setup.navigation_folder();
  fmt::print("{}: navigation meshes: {} made, {} were there\n", folder.string(), report.made,
             report.kept);
  if (!report.without_mesh.empty()) {
    fmt::print(stderr, "note: no mesh of {}, such as {}; see --meshes\n",
               counted(report.without_mesh.size(), "scan"), report.without_mesh.front());
  }
  if (!report.faults.empty()) print_diagnostics(report.faults);
  if (report.made + report.kept == 0 && report.faults.empty()) {
    throw UsageError(fmt::format(
        "{}: no building has a mesh to walk on; looked for model homes (homes.json), "
        "v1/scans/SCAN/matterport_mesh, mp3d/SCAN/SCAN.glb and meshes/SCAN.glb. Give --meshes DIR",
        data.folder().string()));
  }
  return report;
}

std::vector<std::string> splits_of(const dataset::Dataset& data, tasks::ContinuousForm form) {
  return form == tasks::ContinuousForm::kRxr ? data.splits(tasks::Task::kRxr) : data.splits();
}

ExitCode make(const Options& options) {
  const agents::ContinuousSetup& setup = agents::continuous_setup(options.task);
  const dataset::Dataset data = open_data(options.data);
  const FloorsReport floors = make_and_tell(data, setup, options);
  if (options.light) {
    const LightsReport lights = make_home_lights(data, options.threads);
    fmt::print("{}: light of homes: {} made, {} were there\n", (data.folder() / "light").string(),
               lights.made, lights.kept);
  }
  const ExitCode status = floors.faults.empty() ? kSuccess : kFaultsFound;
  if (options.floors_only || floors.made + floors.kept == 0) return status;
  const auto buildings =
      std::make_shared<const continuous::Buildings>(data.folder() / setup.navigation_folder());
  std::string dropped;
  for (const std::string& split : splits_of(data, setup.benchmark->form)) {
    const SplitReport report = derive_split(data, setup, buildings, split, options);
    tell_dropped(split, report, dropped);
    fmt::print("{}: {} episodes of {} paths; {} cannot be walked\n",
               (data.folder() / tasks::episode_places(*setup.benchmark, split).front()).string(),
               report.episodes, report.paths, report.dropped.size());
  }
  if (!options.dropped.empty()) write_output(options.dropped, dropped);
  if (data.synthetic()) fmt::print("SYNTHETIC: model homes made by Enfilade.\n");
  return status;
}

void add_verb(CLI::App& app, int& status) {
  CLI::App& verb =
      *app.add_subcommand("continuous", "Build navigation meshes and derive VLN-CE episodes");
  const auto options = std::make_shared<Options>();
  add_value(verb, "data", options->data, "DATA", "Folder of the data set (default: ENFILADE_DATA)");
  add_setting(verb, "--task", options->task, "NAME",
              "Benchmark: r2r-ce (from R2R) or rxr-ce (from RxR)",
              CLI::IsMember({"r2r-ce", "rxr-ce"}));
  add_value(verb, "--meshes", options->meshes.folder, "DIR",
            "Folder of meshes SCAN.glb, .obj or .ply, instead of the data set's");
  add_setting(verb, "--up", options->meshes.up, "AXIS",
              "Up axis of meshes; format: y for glTF, else z (also mp3d/)",
              CLI::IsMember({"format", "y", "z"}));
  add_setting(verb, "--start-headings", options->headings, "RULE",
              "Start headings: path (the annotation's, as VLN-CE since v1-3) or random",
              CLI::IsMember({"path", "random"}));
  add_whole_number(verb, "--seed", options->seed, "Seed of random headings", 0);
  add_value(verb, "--dropped", options->dropped, "FILE",
            "Write impossible paths, one per line: split, path, scan, reason");
  verb.add_flag("--floors-only", options->floors_only, "Build navigation meshes, no episodes");
  verb.add_flag("--light", options->light,
                "Keep the light of homes (20 MB each), for faster training with images");
  add_threads_option(verb, options->threads);
  set_examples(verb, {"enfilade continuous homes", "enfilade continuous homes --light",
                      "enfilade continuous data --meshes glb --dropped dropped.tsv",
                      "enfilade run --task r2r-ce --data homes --agent shortest"});
  verb.callback([options, &status] { status = make(*options); });
}

}  // namespace
}  // namespace continuous_verb

void add_continuous(CLI::App& app, int& status) { continuous_verb::add_verb(app, status); }

}  // namespace enfilade::apps
