#include "apps/enfilade/home_habitat.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/continuous/split_episodes.h"
#include "apps/enfilade/home_pictures.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/capture/scan_files.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/threads.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/exports/habitat_episodes.h"
#include "enfilade/exports/habitat_objects.h"
#include "enfilade/exports/habitat_scene.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/tasks/benchmark.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;
using exports::HabitatIsland;

constexpr std::string_view kReadme =
    "# Model homes for Habitat: a SYNTHETIC data set made by Enfilade\n\n"
    "Nothing in this folder is real: made-up buildings under `scene_datasets/mp3d`, and episodes "
    "in\n"
    "them under `datasets`. Habitat's programs call such a folder `data`. Numbers from it are not\n"
    "comparable with any from Matterport3D.\n";

// What a home's episodes are made of.
struct HomeForHabitat {
  bool on_floor = false;
  std::vector<exports::PointGoalEpisode> points;
  exports::ObjectGoalScene objects;
};

class HabitatWriter {
 public:
  HabitatWriter(const fs::path& folder, const std::vector<homes::HomeEntry>& homes,
                const HabitatHomesOptions& options)
      : data_(folder), out_(OutputFolder(folder).folder("habitat")), options_(options) {
    const homes::SetProgress progress = set_bar("Habitat");
    std::vector<HomeForHabitat> made(homes.size());
    std::mutex mutex;
    std::size_t done = 0;
    parallel_for(homes.size(), 1, options.threads, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        made[i] = make(homes[i]);
        const std::lock_guard lock(mutex);
        progress(homes[i].scan, ++done, homes.size());
      }
    });
    exports::write_habitat_dataset(out_);
    out_.write("README.md", kReadme);
    for (std::size_t i = 0; i < homes.size(); ++i) made_[homes[i].scan] = std::move(made[i]);
    say("{}: {}, all SYNTHETIC\n", out_.path().string(), counted(homes.size(), "scene"));
  }

  /// VLN-CE's by the rules and on the floor of `enfilade continuous --navmesh habitat`.
  void write_episodes() {
    std::vector<continuous::Building> floors;
    for (const auto& [scan, home] : made_) {
      floors.emplace_back(scan, continuous::load_floor(
                                    out_.path() / exports::habitat_scene_file(scan, ".navmesh")));
      if (!home.on_floor) {
        say(stderr, "note: {}: no viewpoint stands on Habitat's floor, so it has no episodes\n",
            scan);
      }
    }
    const auto buildings = std::make_shared<const continuous::Buildings>(std::move(floors));
    const agents::ContinuousSetup& setup = agents::continuous_setup("r2r-ce");
    for (const std::string& split : data_.splits(tasks::benchmark(tasks::Task::kR2r))) {
      const tasks::Annotations paths = data_.annotations(split);
      const auto [made, experts] = derive_split(paths, *data_.graphs(), buildings, setup, split);
      if (experts) write(exports::habitat_vln_file(split, "_gt"), to_json(*experts));
      write(exports::habitat_vln_file(split), to_json(made.episodes));
      say("VLN-CE, {}: {} of {}; {} cannot be walked\n", split,
          counted(made.episodes.episodes.size(), "episode"), counted(paths.paths.size(), "path"),
          made.dropped.size());
      if (split == "train") write_goals(paths, "train");
      if (split == "val_unseen") write_goals(paths, "val");
    }
  }

 private:
  HomeForHabitat make(const homes::HomeEntry& entry) const {
    const std::string& scan = entry.scan;
    for (const char* ending : {".glb", ".house", ".ply", ".navmesh"}) {
      const fs::path file = exports::habitat_scene_file(scan, ending);
      out_.remove_unfinished(file.parent_path().string(), ending);
    }
    const homes::BuiltHome built = homes::build_home(entry.plan);
    const capture::HouseFiles house =
        capture::make_house_files(built.home.mesh, homes::home_graph(built, scan, 1),
                                  homes::scan_rooms(built.home.plan), options_.image_width);
    continuous::HabitatSceneFloor floor =
        exports::write_habitat_scene(out_, scan, built.home.mesh, house);
    HomeForHabitat made;
    if (!options_.episodes) return made;
    const graph::NavGraph graph(scan::load_connectivity(data_.connectivity_folder(), scan));
    const auto island = exports::habitat_island(std::move(floor), graph);
    const mesh::Mesh of_file =
        mesh::read_mesh(out_.path() / exports::habitat_scene_file(scan, ".glb"),
                        {.up = mesh::UpAxis::kZ})
            .mesh;
    const auto own = exports::habitat_island(
        continuous::HabitatSceneFloor::of_mesh(of_file, mesh::UpAxis::kZ, exports::kObjectNavBody),
        graph);
    if (!island || !own) return made;
    made.on_floor = true;
    const exports::HabitatDraws draws{options_.per_home, options_.seed};
    made.points = exports::draw_point_goals(scan, *island, draws);
    made.objects =
        exports::draw_object_goals(scan, *island, *own, *built.tracer, house.house, draws);
    return made;
  }

  // PointNav and ObjectNav in the homes of a split.
  void write_goals(const tasks::Annotations& paths, const std::string& split) {
    std::set<std::string> scans;
    for (const tasks::PathAnnotation& path : paths.paths) scans.insert(path.scan);
    std::vector<exports::PointGoalEpisode> points;
    std::vector<exports::ObjectGoalScene> objects;
    std::size_t finds = 0;
    for (const std::string& scan : scans) {
      HomeForHabitat& home = made_[scan];
      points.insert(points.end(), home.points.begin(), home.points.end());
      finds += home.objects.episodes.size();
      objects.push_back(std::move(home.objects));
    }
    const auto file = [&split](const char* task) {
      return fmt::format("datasets/{0}/mp3d/v1/{1}/{1}.json.gz", task, split);
    };
    write(file("pointnav"), exports::point_goals_json(points));
    write(file("objectnav"), exports::object_goals_json(objects));
    say("PointNav and ObjectNav, {}: {} and {} in {}\n", split, counted(points.size(), "episode"),
        finds, counted(scans.size(), "home"));
  }

  void write(const std::string& file, const std::string& text) const {
    out_.remove_unfinished(fs::path(file).parent_path().string());
    out_.write(file, gzip(text, 6));
  }

  dataset::Dataset data_;
  OutputFolder out_;
  HabitatHomesOptions options_;
  std::map<std::string, HomeForHabitat> made_;
};

}  // namespace

void write_habitat_homes(const fs::path& folder, const std::vector<homes::HomeEntry>& homes,
                         const HabitatHomesOptions& options) {
  HabitatWriter writer(folder, homes, options);
  if (options.episodes) writer.write_episodes();
}

}  // namespace enfilade::apps
