#include "enfilade/scan/data_root.h"

#include <fmt/format.h>
#include <array>
#include <cstdlib>
#include <span>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"

namespace enfilade::scan {
namespace {

namespace fs = std::filesystem;

using Candidates = std::span<const fs::path>;

const std::array<fs::path, 2> kScanLists{"connectivity/scans.txt", "scans.txt"};
const std::array<fs::path, 4> kRegionMaps{"regions/region_to_panorama.json",
                                          "regions/region_to_panorama.json.gz",
                                          "region_to_panorama.json", "region_to_panorama.json.gz"};

std::array<fs::path, 8> annotation_files(std::string_view split) {
  const std::string name = fmt::format("R2R_{}.json", split);
  std::array<fs::path, 8> files;
  std::size_t k = 0;
  for (const char* folder : {"r2r", "tasks/R2R/data", "R2R", ""}) {
    files[k++] = fs::path(folder) / name;
    files[k++] = fs::path(folder) / (name + ".gz");
  }
  return files;
}

std::optional<fs::path> find_first(const fs::path& folder, Candidates candidates) {
  for (const fs::path& candidate : candidates) {
    std::error_code ignored;
    if (fs::exists(folder / candidate, ignored)) return folder / candidate;
  }
  return std::nullopt;
}

}  // namespace

DataRoot::DataRoot(fs::path folder) : folder_(std::move(folder)) {
  std::error_code ignored;
  if (!fs::is_directory(folder_, ignored)) {
    throw FileError(
        fmt::format("{}: not a folder (looked for a data set there)", folder_.string()));
  }
}

std::optional<DataRoot> DataRoot::from_environment() {
  const char* folder = std::getenv("ENFILADE_DATA");
  if (folder == nullptr || *folder == '\0') return std::nullopt;
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) {
    throw FileError(fmt::format("{}: not a folder (named by ENFILADE_DATA)", folder));
  }
  return DataRoot(folder);
}

fs::path DataRoot::connectivity() const {
  return first_of("list of scans", kScanLists).parent_path();
}

fs::path DataRoot::annotations(std::string_view split) const {
  return first_of(fmt::format("annotations of split {}", quote(split)), annotation_files(split));
}

fs::path DataRoot::regions() const { return first_of("region map", kRegionMaps); }

fs::path DataRoot::first_of(std::string_view what, Candidates places) const {
  if (const auto found = find_first(folder_, places)) return *found;
  std::string tried;
  for (const fs::path& candidate : places) {
    tried += (tried.empty() ? "" : ", ") + candidate.string();
  }
  throw FileError(fmt::format("{}: holds no {}; tried: {}", folder_.string(), what, tried));
}

PanoramaPlaces DataRoot::panoramas() const {
  PanoramaPlaces places;
  if (const auto list = find_first(folder_, kScanLists)) places.connectivity = list->parent_path();
  for (const char* name : {"store", "scans", "v1/scans", "data/v1/scans"}) {
    std::error_code ignored;
    if (fs::is_directory(folder_ / name, ignored)) places.images.push_back(folder_ / name);
  }
  places.images.push_back(folder_);
  return places;
}

}  // namespace enfilade::scan
