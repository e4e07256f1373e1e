/// \file  A data set: graphs, panoramas, episodes and regions of one folder behind one name.
#pragma once
#include <array>
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
#include "enfilade/tasks/objects.h"

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

/// Room-to-Room's splits.
inline constexpr std::array<std::string_view, 4> kSplits{"train", "val_seen", "val_unseen", "test"};

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

  /// Those of kSplits that are there, in this order.
  std::vector<std::string> splits() const;
  bool has_split(std::string_view split) const;  ///< any name: `R2R_<split>.json`
  /// The split as its file has it. Read anew by each call.
  /// \throws FileError naming every place that was tried; InvalidInput
  tasks::Annotations annotations(std::string_view split) const;
  /// The split's episodes, to be walked in graphs(). Read anew by each call.
  /// \throws as annotations(), graphs() and tasks::make_episodes()
  tasks::EpisodeSet episodes(std::string_view split,
                             tasks::Instructions instructions = tasks::Instructions::kScored) const;

  /// The same for any benchmark, from the places of tasks::episode_places(). REVERIE's episodes
  /// need the boxes of objects, objects().
  /// \throws as annotations(), episodes() and objects()
  tasks::Annotations annotations(tasks::Task task, std::string_view split) const;
  tasks::EpisodeSet episodes(tasks::Task task, std::string_view split,
                             tasks::Instructions instructions = tasks::Instructions::kScored) const;
  /// Whether there are annotations of a split, of any name, of a benchmark.
  bool has_split(tasks::Task task, std::string_view split) const;
  /// Those of tasks::Benchmark::splits that are there, in this order.
  std::vector<std::string> splits(tasks::Task task) const;
  /// The benchmarks that it has a usual split of, in the order of tasks::Task.
  std::vector<tasks::Task> benchmarks() const;
  /// Which objects are seen from where: REVERIE's boxes.
  /// \throws FileError naming every place that was tried; InvalidInput
  const tasks::ObjectBoxes& objects() const;

  // Where the files are (scan::DataRoot). Each throws FileError naming every place that was tried.
  std::filesystem::path connectivity_folder() const;                     ///< with scans.txt
  std::filesystem::path annotations_file(std::string_view split) const;  ///< `R2R_<split>.json`
  std::filesystem::path annotations_file(tasks::Task task, std::string_view split) const;
  std::filesystem::path regions_file() const;  ///< region_to_panorama.json
  /// Where panoramas are looked for; never throws.
  scan::PanoramaPlaces panorama_places() const;

 private:
  struct Opened;
  std::shared_ptr<const graph::GraphSet> open_graphs() const;
  std::shared_ptr<Opened> opened_;
};

}  // namespace enfilade::dataset
