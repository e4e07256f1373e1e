// enfilade continuous: navigation meshes and continuous episodes.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/continuous/split_episodes.h"
#include "apps/enfilade/mesh_files.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/continuous/habitat_scene_floor.h"
#include "enfilade/continuous/navigation_mesh.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/threads.h"
#include "enfilade/exports/habitat_episodes.h"
#include "enfilade/exports/habitat_scene.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/tasks/derive_continuous.h"

namespace enfilade::apps::continuous_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string data, task = "r2r-ce", headings = "path", navmesh = "enfilade", dropped, parts;
  MeshSource meshes;
  std::uint64_t seed = 1;
  int threads = 0;
  bool floors_only = false, light = false;
};
bool for_habitat(const Options& options) { return options.parts == "habitat"; }

// Around the viewpoints: what lies farther cannot be part of an episode.
mesh::Box around(const graph::NavGraph& graph) {
  constexpr float kAside = 6, kBelow = 3, kAbove = 3;  // metres
  mesh::Box box{graph.positions().front(), graph.positions().front()};
  for (const Vec3f p : graph.positions()) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return {box.low - Vec3f{kAside, kAside, kBelow}, box.high + Vec3f{kAside, kAside, kAbove}};
}

// glTF's axis where nothing else is said, as a scene dataset of Habitat has it.
mesh::UpAxis axis_of(const dataset::MeshFile& found) {
  if (found.up != mesh::UpAxis::kFormat) return found.up;
  const std::string suffix = found.file.extension().string();
  return suffix == ".glb" || suffix == ".gltf" ? mesh::UpAxis::kY : mesh::UpAxis::kZ;
}

mesh::FloorPolygons floor_of_file(const dataset::MeshFile& found, const graph::NavGraph& graph,
                                  const mesh::Body& body) {
  const mesh::RayTracer tracer(
      std::make_shared<const mesh::Mesh>(read_mesh_file(found.file, {.up = found.up})));
  mesh::PolygonOptions polygons;
  polygons.floor.body = body;
  polygons.floor.within = around(graph);
  return mesh::make_floor_polygons(tracer, polygons);
}

// Counts of a data set's buildings.
struct FloorsReport {
  std::size_t made = 0, kept = 0, replaced = 0;  // replaced: of another kind, among those made
  std::vector<std::string> without_mesh;         // scans
  std::vector<Diagnostic> faults;                // of meshes, a scan each
};

// Makes the navigation mesh of each scan that has a mesh: a synthetic home's own, made again from
// its seed, or a file. Existing ones for the same body are kept; a killed run can be continued.
class FloorMaker {
 public:
  FloorMaker(const dataset::Dataset& data, const agents::ContinuousSetup& setup,
             const MeshSource& source, continuous::FloorKind kind)
      : data_(data),
        setup_(setup),
        source_(source),
        kind_(kind),
        out_(data.folder()),
        folder_(setup.navigation_folder().string()) {
    if (!source.folder.empty() && !fs::is_directory(source.folder)) {
      throw FileError(fmt::format("{}: not a folder (looked for meshes there)", source.folder));
    }
    if (file_exists(data.folder() / "homes.json")) {
      for (homes::HomeEntry& home : homes::read_home_list(data.folder())) {
        homes_.emplace(home.scan, std::move(home));
      }
    }
    static_cast<void>(out_.folder(folder_));
    out_.remove_unfinished(folder_);
  }

  FloorsReport run(int threads, const Progress& progress) {
    const graph::GraphSet& graphs = *data_.graphs();
    std::size_t done = 0;
    parallel_for(graphs.size(), 1, threads, [&](std::size_t first, std::size_t last) {
      for (std::size_t s = first; s < last; ++s) {
        make(graphs.scans()[s], s);
        const std::lock_guard lock(mutex_);
        ++done;
        if (progress) progress(done, graphs.size());
      }
    });
    std::ranges::sort(report_.without_mesh);
    std::ranges::sort(report_.faults, {}, &Diagnostic::file);
    return std::move(report_);
  }

 private:
  void make(const std::string& scan, std::size_t index) {
    const std::string file = folder_ + "/" + continuous::navigation_mesh_name(scan);
    if (is_there(out_.path() / file)) return count(report_.kept);
    const bool other = is_of_other_kind(out_.path() / file);
    const auto home = homes_.find(scan);
    const auto found = home == homes_.end() ? find_mesh_file(data_.folder(), source_, scan)
                                            : std::optional<dataset::MeshFile>();
    if (home == homes_.end() && !found) {
      const std::lock_guard lock(mutex_);
      report_.without_mesh.push_back(scan);
      return;
    }
    try {
      const homes::PlanOptions* plan = home == homes_.end() ? nullptr : &home->second.plan;
      if (kind_ == continuous::FloorKind::kHabitat) {
        out_.write(file,
                   plan != nullptr ? habitat_floor_of_home(*plan) : habitat_floor_of_file(*found));
      } else {
        const ScanIndex scan_index(static_cast<std::uint32_t>(index));
        continuous::save_navigation_mesh(
            plan != nullptr
                ? homes::make_home_floor(homes::build_home(*plan, homes::HomeSurfaces::kPlain),
                                         setup_.body)
                : floor_of_file(*found, data_.graphs()->graph(scan_index), setup_.body),
            out_.file(file));
      }
      count(report_.made);
      if (other) count(report_.replaced);
    } catch (const InvalidInput& error) {  // the other buildings are made all the same
      const std::lock_guard lock(mutex_);
      Diagnostic fault = error.diagnostics().front();
      fault.file = home == homes_.end() ? found->file.string() : scan;
      report_.faults.push_back(std::move(fault));
    }
  }

  // By way of the GLB that `homes --parts habitat` writes: the order of triangles and the axis
  // count.
  std::string habitat_floor_of_home(const homes::PlanOptions& plan) const {
    const homes::BuiltHome built = homes::build_home(plan, homes::HomeSurfaces::kPlain);
    const mesh::Mesh of_file = mesh::parse_mesh(mesh::to_glb(built.home.mesh, mesh::UpAxis::kZ),
                                                "home.glb", {.up = mesh::UpAxis::kZ})
                                   .mesh;
    return continuous::HabitatSceneFloor::of_mesh(of_file, mesh::UpAxis::kZ, setup_.body).file();
  }

  std::string habitat_floor_of_file(const dataset::MeshFile& found) const {
    const mesh::UpAxis up = axis_of(found);
    const mesh::Mesh mesh = read_mesh_file(found.file, {.up = up});
    return continuous::HabitatSceneFloor::of_mesh(mesh, up, setup_.body).file();
  }

  bool is_of_other_kind(const fs::path& file) const {
    return file_exists(file) && continuous::floor_kind_of(file) != kind_;
  }

  bool is_there(const fs::path& file) const {
    if (!file_exists(file) || is_of_other_kind(file)) return false;
    if (kind_ == continuous::FloorKind::kHabitat) {
      return continuous::is_habitat_floor_of(file, setup_.body);
    }
    const mesh::Body have = continuous::load_navigation_mesh(file).body;
    const mesh::Body& want = setup_.body;
    return have.radius == want.radius && have.height == want.height && have.step == want.step &&
           have.slope == want.slope;
  }

  void count(std::size_t& number) {
    const std::lock_guard lock(mutex_);
    ++number;
  }

  const dataset::Dataset& data_;
  const agents::ContinuousSetup& setup_;
  const MeshSource& source_;
  continuous::FloorKind kind_;
  OutputFolder out_;
  std::string folder_;
  std::map<std::string, homes::HomeEntry> homes_;
  std::mutex mutex_;
  FloorsReport report_;
};

// What became of one split.
struct SplitReport {
  std::size_t episodes = 0, paths = 0;
  std::vector<tasks::DroppedPath> dropped;
};

SplitReport write_split(const dataset::Dataset& data, const agents::ContinuousSetup& setup,
                        const std::shared_ptr<const continuous::Buildings>& buildings,
                        const std::string& split, const Options& options) {
  const tasks::Annotations annotations = data.annotations(setup.benchmark->task, split);
  tasks::DeriveOptions derive;
  derive.seed = options.seed;
  if (options.headings == "random") derive.start_headings = tasks::StartHeadings::kRandom;
  const auto [derived, experts] =
      derive_split(annotations, *data.graphs(), buildings, setup, split, derive);
  const std::string text = gzip(to_json(derived.episodes), 6);
  const std::string walks = experts ? gzip(to_json(*experts), 6) : std::string();
  const OutputFolder out(data.folder());
  if (experts) out.write(tasks::expert_places(*setup.benchmark, split).front().string(), walks);
  out.write(tasks::episode_places(*setup.benchmark, split).front().string(), text);
  if (for_habitat(options)) {
    const OutputFolder habitat = out.folder("habitat");
    if (experts) habitat.write(exports::habitat_vln_file(split, "_gt"), walks);
    habitat.write(exports::habitat_vln_file(split), text);
  }
  return {derived.episodes.episodes.size(), annotations.paths.size() - derived.dropped.size(),
          derived.dropped};
}

FloorsReport make_and_tell(const dataset::Dataset& data, const agents::ContinuousSetup& setup,
                           const Options& options) {
  const auto kind = find_enum<continuous::FloorKind>(options.navmesh).value();
  FloorsReport report =
      FloorMaker(data, setup, options.meshes, kind).run(options.threads, progress_bar("floors"));
  const fs::path folder = data.folder() / setup.navigation_folder();
  say("{}: navigation meshes: {} made, {} were there{}\n", folder.string(), report.made,
      report.kept,
      kind == continuous::FloorKind::kHabitat ? fmt::format(" (floor: {})", name_of(kind)) : "");
  if (report.replaced > 0) {
    say(stderr, "note: {} of the other kind replaced; results on those have other scores here\n",
        counted(report.replaced, "floor"));
  }
  if (!report.without_mesh.empty()) {
    say(stderr, "note: no mesh of {}, such as {}; see --meshes\n",
        counted(report.without_mesh.size(), "scan"), report.without_mesh.front());
  }
  if (!report.faults.empty()) print_diagnostics(report.faults);
  if (report.made + report.kept == 0 && report.faults.empty()) {
    throw UsageError(fmt::format(
        "{}: no building has a mesh to walk on; looked for model homes (homes.json), "
        "v1/scans/SCAN/matterport_mesh, mp3d/SCAN/SCAN.glb, hm3d/SPLIT/00800-NAME/NAME.glb and "
        "meshes/SCAN.glb. Give --meshes DIR",
        data.folder().string()));
  }
  return report;
}

// Scenes of buildings as Habitat opens them: z up, with their floors.
void write_scenes(const dataset::Dataset& data, const agents::ContinuousSetup& setup,
                  const Options& options) {
  const OutputFolder out = OutputFolder(data.folder()).folder("habitat");
  std::size_t written = 0;
  const auto& scans = data.graphs()->scans();
  const Progress progress = progress_bar("scenes");
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const std::string& scan = scans[s];
    const fs::path floor =
        data.folder() / setup.navigation_folder() / continuous::navigation_mesh_name(scan);
    const auto found = find_mesh_file(data.folder(), options.meshes, scan);
    if (found && file_exists(floor)) {
      const mesh::Mesh mesh = read_mesh_file(found->file, {.up = axis_of(*found)});
      out.write(exports::habitat_scene_file(scan, ".glb"), mesh::to_glb(mesh, mesh::UpAxis::kZ));
      out.write(exports::habitat_scene_file(scan, ".navmesh"), read_file(floor));
      ++written;
    }
    if (progress) progress(s + 1, scans.size());
  }
  exports::write_habitat_dataset(out);
  say("{}: {}\n", out.path().string(), counted(written, "scene"));
}

// What has no Habitat's floor, or has scenes made otherwise, is refused before anything is made.
void check_habitat(const dataset::Dataset& data, const Options& options) {
  if (!for_habitat(options)) return;
  if (options.navmesh != "habitat" || options.task != "r2r-ce" || options.floors_only) {
    throw UsageError(
        "--parts habitat: wants --navmesh habitat and --task r2r-ce, and no --floors-only");
  }
  if (file_exists(data.folder() / "homes.json")) {
    throw UsageError(
        fmt::format("--parts habitat: {} has homes; `enfilade homes -o {} --parts "
                    "habitat` writes theirs, with labels",
                    data.folder().string(), data.folder().string()));
  }
}

ExitCode make(const Options& options) {
  const agents::ContinuousSetup& setup = agents::continuous_setup(options.task);
  const dataset::Dataset data = open_data(options.data);
  check_habitat(data, options);
  const FloorsReport floors = make_and_tell(data, setup, options);
  if (options.light) {
    const LightsReport lights = make_home_lights(data, options.threads);
    say("{}: light of homes: {} made, {} were there\n", (data.folder() / "light").string(),
        lights.made, lights.kept);
  }
  const ExitCode status = floors.faults.empty() ? kSuccess : kFaultsFound;
  if (options.floors_only || floors.made + floors.kept == 0) return status;
  if (for_habitat(options)) write_scenes(data, setup, options);
  const auto buildings = agents::open_buildings(*setup.benchmark, data.folder());
  std::string dropped;
  for (const std::string& split : data.splits(tasks::benchmark(setup.benchmark->task))) {
    const SplitReport report = write_split(data, setup, buildings, split, options);
    for (const tasks::DroppedPath& path : report.dropped) {
      dropped += fmt::format("{}\t{}\t{}\t{}\n", split, path.id, path.scan, path.why);
    }
    say("{}: {} episodes of {} paths; {} cannot be walked\n",
        (data.folder() / tasks::episode_places(*setup.benchmark, split).front()).string(),
        report.episodes, report.paths, report.dropped.size());
  }
  if (!options.dropped.empty()) write_output(options.dropped, dropped);
  if (data.synthetic()) say("SYNTHETIC: model homes made by Enfilade.\n");
  return status;
}

}  // namespace

void add(CLI::App& app, int& status) {
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
              "Up axis; format: y for glTF, else z (also mp3d/, hm3d/)",
              CLI::IsMember({"format", "y", "z"}));
  add_setting(verb, "--navmesh", options->navmesh, "FLOOR",
              "Floor: enfilade, or habitat as Habitat-Sim 0.3.3 makes it",
              CLI::IsMember(enum_names<continuous::FloorKind>()));
  add_value(verb, "--parts", options->parts, "PART",
            "habitat: also DATA/habitat, scenes and episodes as Habitat's programs open them")
      ->check(CLI::IsMember({"habitat"}));
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
                      "enfilade continuous homes --navmesh habitat",
                      "enfilade continuous data --navmesh habitat --parts habitat",
                      "enfilade run --task r2r-ce --data homes --agent shortest"});
  verb.callback([options, &status] { status = make(*options); });
}

}  // namespace enfilade::apps::continuous_verb
