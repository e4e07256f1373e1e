/// \file  A data set: graphs, panoramas, episodes and regions of one folder behind one name.
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/render/face_cache.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/scan/regions.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/split.h"

namespace enfilade::dataset {

/// For a data set whose parts do not all lie in one folder. Empty fields: as the folder has them.
struct DatasetConfig {
  std::filesystem::path folder;               ///< may be empty if what is used is named below
  std::filesystem::path connectivity;         ///< folder of `<scan>_connectivity.json`
  std::vector<std::filesystem::path> images;  ///< folders in which panoramas are looked for
  std::vector<std::string> scans;             ///< only these, in this order
  /// Where decoded faces are shared with other processes (render/face_cache.h); no value: nowhere.
  std::optional<render::SharedCacheConfig> shared_cache = {};
};

/// What Dataset::split() opens beside the episodes.
struct SplitOptions {
  tasks::Instructions instructions = tasks::Instructions::kScored;
  bool experts = true;  ///< continuous: the experts' walks, with which scorers compare
};

/// A part of a data set, for people: what is there, or what is missing and how to get it.
struct Part {
  std::string name;  ///< "connectivity", "R2R val_seen", "regions", "panoramas"
  bool present = false;
  std::string found;   ///< "90 scans"; or why it cannot be used
  std::string advice;  ///< how to get it; empty if it is there
};

/// A folder in one of the layouts in use:
/// - Enfilade's and the homes': `connectivity/`, `r2r/`, `regions/`, `store/`
/// - a checkout of Matterport3DSimulator: `connectivity/`, `tasks/R2R/data/`, `data/v1/scans/`
/// - all files side by side
///
///     const Dataset d("data");
///     sim::Simulator simulator(d.graphs(), sim::SimulatorConfig::room_to_room());
///     const tasks::EpisodeSet episodes = d.episodes("val_unseen");
///
/// A folder of stores alone is a data set too: stores bring their graphs. Making one looks at the
/// folder only; each part is opened at its first use, once, and copies of a
/// Dataset share it. All functions may be called from any thread. What they return by reference
/// lives as long as a copy of the Dataset does.
class Dataset {
 public:
  /// \throws FileError if `folder` is not a folder
  explicit Dataset(const std::filesystem::path& folder);
  explicit Dataset(DatasetConfig config);  ///< \throws as above, for a folder that is named
  /// The folder that the environment variable ENFILADE_DATA names; nothing if it is unset or empty.
  /// \throws FileError if it names no folder
  static std::optional<Dataset> from_environment();

  const std::filesystem::path& folder() const noexcept;
  /// Whether Enfilade made the buildings (homes.json or the first line of README.md says so). Every
  /// figure of theirs has to be called synthetic.
  bool synthetic() const;
  /// Everything that a data set can have, each part looked for, annotations read: about a second
  /// for R2R. Never throws for what is missing or broken.
  std::vector<Part> examine() const;

  /// The navigation graphs, one per scan.
  /// \throws FileError, InvalidInput: as graph::GraphSet::open(), scan::Store::open()
  const std::shared_ptr<const graph::GraphSet>& graphs() const;
  /// The panoramas, in the order of the graphs: one ScanIndex serves both. Whether a scan has any
  /// shows when it is used. \throws as graphs()
  const std::shared_ptr<const scan::PanoramaSet>& panoramas() const;
  /// Decoded faces of panoramas(), shared by everyone who draws from this data set.
  /// \throws as graphs(); FileError for a shared cache, as render::FaceCache
  const std::shared_ptr<render::FaceCache>& faces() const;
  /// Which region each viewpoint is in. \throws FileError, InvalidInput
  const scan::RegionMap& regions() const;

  /// A split of a benchmark of either world, from the places of tasks::episode_places(). Read anew
  /// by each call.
  /// \throws FileError naming every place that was tried; InvalidInput, also for a split without
  /// episodes; as graphs(), objects() and tasks::make_episodes()
  tasks::Split split(const tasks::Benchmark& benchmark, std::string_view name,
                     const SplitOptions& options = {}) const;
  /// Whether there is a file of a split, of any name.
  bool has_split(const tasks::Benchmark& benchmark, std::string_view split) const {
    return find_episodes(benchmark, split).has_value();
  }
  bool has_split(std::string_view split) const {  ///< of Room-to-Room
    return has_split(tasks::benchmark(tasks::Task::kR2r), split);
  }
  /// Those of tasks::Benchmark::splits that are there, in this order.
  std::vector<std::string> splits(const tasks::Benchmark& benchmark) const;
  /// Those that it has a usual split of, in the order of tasks::benchmarks().
  std::vector<const tasks::Benchmark*> benchmarks() const;

  /// \name A split on graphs \throws as split()
  /// @{
  /// The content of the file.
  tasks::Annotations annotations(tasks::Task task, std::string_view split) const;
  /// The same of Room-to-Room.
  tasks::Annotations annotations(std::string_view split) const {
    return annotations(tasks::Task::kR2r, split);
  }
  /// The episodes.
  tasks::EpisodeSet episodes(tasks::Task task, std::string_view split,
                             tasks::Instructions instructions = tasks::Instructions::kScored) const;
  /// The same of Room-to-Room.
  tasks::EpisodeSet episodes(std::string_view split, tasks::Instructions instructions =
                                                         tasks::Instructions::kScored) const {
    return episodes(tasks::Task::kR2r, split, instructions);
  }
  /// @}
  /// Which objects are seen from where: REVERIE's boxes.
  /// \throws FileError naming every place that was tried; InvalidInput
  const tasks::ObjectBoxes& objects() const;

  // Where the files are (scan::DataRoot). Each throws FileError naming every place that was tried.
  std::filesystem::path connectivity_folder() const;  ///< with scans.txt
  /// The file of a split, in either world.
  std::filesystem::path episodes_file(const tasks::Benchmark& benchmark,
                                      std::string_view split) const;
  /// The same; nothing if there is none.
  std::optional<std::filesystem::path> find_episodes(const tasks::Benchmark& benchmark,
                                                     std::string_view split) const;
  std::filesystem::path regions_file() const;  ///< region_to_panorama.json
  /// Where panoramas are looked for; never throws.
  scan::PanoramaPlaces panorama_places() const;

 private:
  struct Opened;
  std::shared_ptr<const graph::GraphSet> open_graphs() const;
  std::shared_ptr<Opened> opened_;
};

}  // namespace enfilade::dataset
