#include "enfilade/dataset/dataset.h"

#include <fmt/format.h>
#include <algorithm>
#include <map>
#include <mutex>
#include <span>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/names.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/scan/store.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::dataset {
namespace {

namespace fs = std::filesystem;

// The stores of these folders by scan, the first of a name; of all scans if none are named.
std::map<std::string, fs::path> find_stores(std::span<const fs::path> folders,
                                            std::span<const std::string> scans) {
  std::map<std::string, fs::path> stores;
  for (const fs::path& folder : folders) {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder, ignored)) {
      if (entry.path().extension() != ".enfilade") continue;
      const std::string scan = entry.path().stem().string();
      const bool wanted = scans.empty() || std::ranges::find(scans, scan) != scans.end();
      if (wanted) stores.emplace(scan, entry.path());
    }
  }
  return stores;
}

std::shared_ptr<const graph::GraphSet> graphs_of(const std::map<std::string, fs::path>& stores) {
  std::vector<graph::NavGraph> graphs;
  for (const auto& [scan, file] : stores) {
    graphs.emplace_back(scan::Store::open(file)->connectivity());
  }
  return graph::GraphSet::of(std::move(graphs));
}

/// Made at its first use; where making it throws, the next call tries again.
template <class T>
class Lazy {
 public:
  template <class Make>
  const T& get(const Make& make) {
    const std::scoped_lock lock(mutex_);
    if (!value_) value_.emplace(make());
    return *value_;
  }

 private:
  std::mutex mutex_;
  std::optional<T> value_;
};

// What `look` tells, or that the part is missing and why.
template <class Look>
Part look_for(std::string name, const Look& look, std::string advice) {
  try {
    std::string found = look();  // may throw: the name has to be there still
    return {std::move(name), true, std::move(found), {}};
  } catch (const Error& error) {
    return {std::move(name), false, error.what(), std::move(advice)};
  }
}

std::string count_instructions(const tasks::Annotations& annotations) {
  std::size_t instructions = 0;
  for (const auto& path : annotations.paths) instructions += path.instructions.size();
  return fmt::format("{} paths, {} instructions", annotations.paths.size(), instructions);
}

std::string count_regions(const scan::RegionMap& regions) {
  return fmt::format("{} regions in {} scans", regions.regions(), regions.scans().size());
}

std::string count_panoramas(const Dataset& dataset) {
  const scan::PanoramaSet& panoramas = *dataset.panoramas();
  std::size_t found = 0;
  std::string why_not;
  for (std::size_t scan = 0; scan < panoramas.size(); ++scan) {
    try {
      if (panoramas.find_source(ScanIndex(scan)) != nullptr) ++found;
    } catch (const Error& error) {
      why_not += fmt::format("\n{}", error.what());
    }
  }
  if (found == 0 || !why_not.empty()) {
    throw LookupError(fmt::format("of {} of {} scans, below {}{}", found, panoramas.size(),
                                  dataset.folder().string(), why_not));
  }
  return fmt::format("of {} of {} scans", found, panoramas.size());
}

// The first of some files or folders that is there.
std::optional<fs::path> first_there(const fs::path& folder, const std::vector<fs::path>& places) {
  for (const fs::path& place : places) {
    std::error_code ignored;
    if (fs::exists(folder / place, ignored)) return folder / place;
  }
  return std::nullopt;
}

}  // namespace

struct Dataset::Opened {
  DatasetConfig config;
  std::optional<scan::DataRoot> root;  // none: what is used is named in the configuration
  Lazy<std::shared_ptr<const graph::GraphSet>> graphs;
  Lazy<std::shared_ptr<const scan::PanoramaSet>> panoramas;
  Lazy<std::shared_ptr<render::FaceCache>> faces;
  Lazy<scan::RegionMap> regions;
  Lazy<tasks::ObjectBoxes> objects;

  const scan::DataRoot& files() const {
    if (root) return *root;
    throw FileError("no folder of data was named, only one of graphs or panoramas");
  }
};

Dataset::Dataset(const fs::path& folder) : Dataset(DatasetConfig{folder, {}, {}, {}}) {}

Dataset::Dataset(DatasetConfig config) : opened_(std::make_shared<Opened>()) {
  const bool parts = !config.connectivity.empty() || !config.images.empty();
  if (!config.folder.empty() || !parts) opened_->root.emplace(config.folder);
  opened_->config = std::move(config);
}

std::optional<Dataset> Dataset::from_environment() {
  const auto root = scan::DataRoot::from_environment();
  return root ? std::optional(Dataset(root->folder())) : std::nullopt;
}

const fs::path& Dataset::folder() const noexcept { return opened_->config.folder; }

bool Dataset::synthetic() const {
  std::error_code ignored;
  if (fs::exists(folder() / "homes.json", ignored)) return true;
  const fs::path readme = folder() / "README.md";
  if (!fs::is_regular_file(readme, ignored)) return false;
  const std::string text = read_file(readme);
  return text.substr(0, text.find('\n')).find("SYNTHETIC") != std::string::npos;
}

const std::shared_ptr<const graph::GraphSet>& Dataset::graphs() const {
  return opened_->graphs.get([this] { return open_graphs(); });
}

std::shared_ptr<const graph::GraphSet> Dataset::open_graphs() const {
  const scan::PanoramaPlaces places = panorama_places();
  if (places.connectivity.empty()) {
    if (const auto stores = find_stores(places.images, opened_->config.scans); !stores.empty()) {
      return graphs_of(stores);
    }
    return graph::GraphSet::open(connectivity_folder());  // says what was tried
  }
  if (!opened_->config.scans.empty())
    return graph::GraphSet::open(places.connectivity, opened_->config.scans);
  return graph::GraphSet::open_shared(places.connectivity);
}

const std::shared_ptr<const scan::PanoramaSet>& Dataset::panoramas() const {
  return opened_->panoramas.get([this] {
    return scan::PanoramaSet::open(panorama_places(), opened_->config.scans.empty()
                                                          ? graphs()->scans()
                                                          : opened_->config.scans);
  });
}

const std::shared_ptr<render::FaceCache>& Dataset::faces() const {
  return opened_->faces.get([this] {
    return std::make_shared<render::FaceCache>(
        panoramas(),
        render::FaceCacheConfig{.prefetch_thread = false, .shared = opened_->config.shared_cache});
  });
}

const scan::RegionMap& Dataset::regions() const {
  return opened_->regions.get([this] { return scan::RegionMap::load(regions_file()); });
}

std::optional<fs::path> Dataset::find_episodes(const tasks::Benchmark& benchmark,
                                               std::string_view split) const {
  if (!opened_->root || split.empty()) return std::nullopt;
  return first_there(folder(), tasks::episode_places(benchmark, split));
}

fs::path Dataset::episodes_file(const tasks::Benchmark& benchmark, std::string_view split) const {
  if (split.empty()) throw ArgumentError("annotations of a split without a name");
  const std::vector<fs::path> places = tasks::episode_places(benchmark, split);
  if (!benchmark.continuous()) {
    return opened_->files().first_of(
        fmt::format("annotations of split {} of {}", quote(split), benchmark.title), places);
  }
  if (auto file = first_there(opened_->files().folder(), places)) return *std::move(file);
  std::vector<std::string> tried;
  for (const fs::path& place : places) tried.push_back((folder() / place).string());
  throw FileError(
      fmt::format("no episodes of {} {}: tried {}; `enfilade continuous {}` makes them "
                  "of Room-to-Room's",
                  benchmark.name, split, fmt::join(tried, ", "), folder().string()));
}

tasks::Split Dataset::split(const tasks::Benchmark& benchmark, std::string_view name,
                            const SplitOptions& options) const {
  const fs::path file = episodes_file(benchmark, name);
  if (!benchmark.continuous()) {
    tasks::Split read(episodes(benchmark.task, name, options.instructions));
    tasks::require_episodes(read, file.string());
    return read;
  }
  auto read = std::make_shared<const tasks::ContinuousEpisodes>(
      tasks::load_continuous_episodes(file, std::string(name)));
  std::shared_ptr<const tasks::ExpertWalks> experts;
  if (options.experts) {
    if (const auto walks = first_there(folder(), tasks::expert_places(benchmark, name))) {
      experts = std::make_shared<const tasks::ExpertWalks>(tasks::load_expert_walks(*walks));
    }
  }
  const tasks::Split split(benchmark, std::move(read), std::move(experts));
  tasks::require_episodes(split, file.string());
  return split;
}

tasks::Annotations Dataset::annotations(tasks::Task task, std::string_view split) const {
  return tasks::load_annotations(episodes_file(tasks::benchmark(task), split), std::string(split),
                                 task);
}

tasks::EpisodeSet Dataset::episodes(tasks::Task task, std::string_view split,
                                    tasks::Instructions instructions) const {
  const tasks::Annotations read = annotations(task, split);
  const bool boxes = task == tasks::Task::kReverie &&
                     (tasks::needs_boxes(read) || first_there(folder(), tasks::object_places()));
  auto set = tasks::make_episodes(read, graphs(), instructions, boxes ? &objects() : nullptr);
  if (boxes) set.objects = std::shared_ptr<const tasks::ObjectBoxes>(opened_, &objects());
  return set;
}

std::vector<std::string> Dataset::splits(const tasks::Benchmark& benchmark) const {
  std::vector<std::string> found;
  for (const std::string_view split : benchmark.splits) {
    if (has_split(benchmark, split)) found.emplace_back(split);
  }
  return found;
}

std::vector<const tasks::Benchmark*> Dataset::benchmarks() const {
  std::vector<const tasks::Benchmark*> found;
  for (const tasks::Benchmark& one : tasks::benchmarks()) {
    if (!splits(one).empty()) found.push_back(&one);
  }
  return found;
}

const tasks::ObjectBoxes& Dataset::objects() const {
  return opened_->objects.get([this] {
    return tasks::ObjectBoxes::load(
        opened_->files().first_of("boxes of objects", tasks::object_places()));
  });
}

fs::path Dataset::connectivity_folder() const {
  const fs::path& named = opened_->config.connectivity;
  return named.empty() ? opened_->files().connectivity() : named;
}

fs::path Dataset::regions_file() const { return opened_->files().regions(); }

scan::PanoramaPlaces Dataset::panorama_places() const {
  const DatasetConfig& named = opened_->config;
  scan::PanoramaPlaces places;
  if (opened_->root) places = opened_->root->panoramas();
  if (!named.connectivity.empty()) places.connectivity = named.connectivity;
  if (!named.images.empty()) places.images = named.images;
  return places;
}

std::vector<Part> Dataset::examine() const {
  std::vector<Part> parts;
  parts.push_back(look_for(
      "connectivity", [&] { return fmt::format("{} scans", graphs()->size()); },
      "copy connectivity/ of github.com/peteanderson80/Matterport3DSimulator into the folder"));
  for (const std::string_view split : tasks::benchmark(tasks::Task::kR2r).splits) {
    parts.push_back(look_for(
        fmt::format("R2R {}", split), [&] { return count_instructions(annotations(split)); },
        fmt::format("R2R_{}.json is part of the R2R download; only work on it needs it", split)));
  }
  parts.push_back(look_for(
      "regions", [&] { return count_regions(regions()); },
      "only `enfilade sample` needs them: region_to_panorama.json of CVDN"));
  parts.push_back(look_for(
      "panoramas", [&] { return count_panoramas(*this); },
      "Matterport3D's pictures are had from niessner.github.io/Matterport; put them in v1/scans "
      "below the data, or name their folder by --images. `enfilade import` takes your own."));
  return parts;
}

}  // namespace enfilade::dataset
