#include "enfilade/scan/data_root.h"

#include <fmt/format.h>
#include <array>
#include <cstdlib>
#include <span>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::scan {
namespace {

namespace fs = std::filesystem;

using Candidates = std::span<const fs::path>;

const std::array<fs::path, 2> kScanLists{"connectivity/scans.txt", "scans.txt"};
const std::array<fs::path, 2> kRegionMaps{"regions/region_to_panorama.json",
                                          "region_to_panorama.json"};

std::array<fs::path, 4> annotation_files(std::string_view split) {
  const std::string name = fmt::format("R2R_{}.json", split);
  return {fs::path("r2r") / name, fs::path("tasks/R2R/data") / name, fs::path("R2R") / name, name};
}

std::optional<fs::path> find_first(const fs::path& folder, Candidates candidates) {
  for (const fs::path& candidate : candidates) {
    std::error_code ignored;
    if (fs::exists(folder / candidate, ignored)) return folder / candidate;
  }
  return std::nullopt;
}

fs::path first_existing(const fs::path& folder, std::string_view what, Candidates candidates) {
  if (const auto found = find_first(folder, candidates)) return *found;
  std::string tried;
  for (const fs::path& candidate : candidates) {
    tried += (tried.empty() ? "" : ", ") + candidate.string();
  }
  throw FileError(fmt::format("{}: holds no {}; tried: {}", folder.string(), what, tried));
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
  return first_existing(folder_, "list of scans", kScanLists).parent_path();
}

fs::path DataRoot::annotations(std::string_view split) const {
  return first_existing(folder_, fmt::format("annotations of split {:?}", split),
                        annotation_files(split));
}

bool DataRoot::has_annotations(std::string_view split) const {
  return !split.empty() && find_first(folder_, annotation_files(split)).has_value();
}

fs::path DataRoot::regions() const { return first_existing(folder_, "region map", kRegionMaps); }

fs::path DataRoot::first_of(std::string_view what, Candidates places) const {
  return first_existing(folder_, what, places);
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
