#include "enfilade/dataset/dataset.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <mutex>
#include <span>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/scan/store.h"

namespace enfilade::dataset {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 4> kSplits{"train", "val_seen", "val_unseen", "test"};
const std::array<fs::path, 2> kScanLists{"connectivity/scans.txt", "scans.txt"};

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

bool has_any(const fs::path& folder, std::span<const fs::path> candidates) {
  return !folder.empty() && std::ranges::any_of(candidates, [&folder](const fs::path& candidate) {
    return is_there(folder / candidate);
  });
}

fs::path first_existing(const fs::path& folder, std::string_view what,
                        std::span<const fs::path> candidates) {
  std::string tried;
  for (const fs::path& candidate : candidates) {
    if (is_there(folder / candidate)) return folder / candidate;
    tried += (tried.empty() ? "" : ", ") + candidate.string();
  }
  throw FileError(fmt::format("{}: holds no {}; tried: {}", folder.string(), what, tried));
}

std::array<fs::path, 4> annotation_places(std::string_view split) {
  const std::string name = fmt::format("R2R_{}.json", split);
  return {fs::path("r2r") / name, fs::path("tasks/R2R/data") / name, fs::path("R2R") / name, name};
}

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

}  // namespace

struct Dataset::Opened {
  Lazy<std::shared_ptr<const graph::GraphSet>> graphs;
  Lazy<std::shared_ptr<const scan::PanoramaSet>> panoramas;
  Lazy<std::shared_ptr<render::FaceCache>> faces;
  Lazy<scan::RegionMap> regions;
};

Dataset::Dataset(const fs::path& folder) : Dataset(DatasetConfig{folder, {}, {}, {}}) {}

Dataset::Dataset(DatasetConfig config)
    : config_(std::make_shared<const DatasetConfig>(std::move(config))),
      opened_(std::make_shared<Opened>()) {
  const bool parts = !config_->connectivity.empty() || !config_->images.empty();
  if (is_folder(folder()) || (folder().empty() && parts)) return;
  throw FileError(fmt::format("{}: not a folder (looked for a data set there)", folder().string()));
}

std::optional<Dataset> Dataset::from_environment() {
  const char* folder = std::getenv("ENFILADE_DATA");
  if (folder == nullptr || *folder == '\0') return std::nullopt;
  if (!is_folder(folder)) {
    throw FileError(fmt::format("{}: not a folder (named by ENFILADE_DATA)", folder));
  }
  return Dataset(folder);
}

const fs::path& Dataset::folder() const noexcept { return config_->folder; }

bool Dataset::synthetic() const {
  if (is_there(folder() / "homes.json")) return true;
  const fs::path readme = folder() / "README.md";
  std::error_code ignored;
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
    if (const auto stores = find_stores(places.images, config_->scans); !stores.empty()) {
      return graphs_of(stores);
    }
    return graph::GraphSet::open(connectivity_folder());  // says what was tried
  }
  if (!config_->scans.empty()) return graph::GraphSet::open(places.connectivity, config_->scans);
  return graph::GraphSet::open_shared(places.connectivity);
}

const std::shared_ptr<const scan::PanoramaSet>& Dataset::panoramas() const {
  return opened_->panoramas.get([this] {
    return scan::PanoramaSet::open(panorama_places(),
                                   config_->scans.empty() ? graphs()->scans() : config_->scans);
  });
}

const std::shared_ptr<render::FaceCache>& Dataset::faces() const {
  return opened_->faces.get([this] {
    return std::make_shared<render::FaceCache>(panoramas(),
                                               render::FaceCacheConfig{.prefetch_thread = false});
  });
}

const scan::RegionMap& Dataset::regions() const {
  return opened_->regions.get([this] { return scan::RegionMap::load(regions_file()); });
}

std::vector<std::string> Dataset::splits() const {
  std::vector<std::string> found;
  for (const char* split : kSplits) {
    if (has_split(split)) found.emplace_back(split);
  }
  return found;
}

bool Dataset::has_split(std::string_view split) const {
  return !split.empty() && has_any(folder(), annotation_places(split));
}

r2r::Annotations Dataset::annotations(std::string_view split) const {
  return r2r::load_annotations(annotations_file(split), std::string(split));
}

r2r::EpisodeSet Dataset::episodes(std::string_view split, r2r::Instructions instructions) const {
  return r2r::make_episodes(annotations(split), graphs(), instructions);
}

fs::path Dataset::connectivity_folder() const {
  if (!config_->connectivity.empty()) return config_->connectivity;
  return first_existing(folder(), "list of scans", kScanLists).parent_path();
}

fs::path Dataset::annotations_file(std::string_view split) const {
  return first_existing(folder(), fmt::format("annotations of split {:?}", split),
                        annotation_places(split));
}

fs::path Dataset::regions_file() const {
  const std::array<fs::path, 2> places{"regions/region_to_panorama.json",
                                       "region_to_panorama.json"};
  return first_existing(folder(), "region map", places);
}

scan::PanoramaPlaces Dataset::panorama_places() const {
  scan::PanoramaPlaces places{config_->images, config_->connectivity};
  if (places.connectivity.empty() && has_any(folder(), kScanLists)) {
    places.connectivity = connectivity_folder();
  }
  if (!places.images.empty()) return places;
  for (const char* name : {"store", "scans", "v1/scans", "data/v1/scans"}) {
    if (is_folder(folder() / name)) places.images.push_back(folder() / name);
  }
  places.images.push_back(folder());
  return places;
}

}  // namespace enfilade::dataset
