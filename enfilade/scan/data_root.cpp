#include "enfilade/scan/data_root.h"

#include <fmt/format.h>
#include <cstdlib>
#include <initializer_list>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::scan {
namespace {

namespace fs = std::filesystem;

fs::path first_existing(const fs::path& folder, std::string_view what,
                        std::initializer_list<fs::path> candidates) {
  std::string tried;
  for (const fs::path& candidate : candidates) {
    std::error_code ignored;
    if (fs::exists(folder / candidate, ignored)) return folder / candidate;
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
  return first_existing(folder_, "list of scans", {"connectivity/scans.txt", "scans.txt"})
      .parent_path();
}

fs::path DataRoot::annotations(std::string_view split) const {
  const std::string name = fmt::format("R2R_{}.json", split);
  return first_existing(
      folder_, fmt::format("annotations of split {:?}", split),
      {fs::path("r2r") / name, fs::path("tasks/R2R/data") / name, fs::path("R2R") / name, name});
}

fs::path DataRoot::regions() const {
  return first_existing(folder_, "region map",
                        {"regions/region_to_panorama.json", "region_to_panorama.json"});
}

PanoramaPlaces DataRoot::panoramas() const {
  PanoramaPlaces places{{}, connectivity()};
  for (const char* name : {"store", "scans", "v1/scans", "data/v1/scans"}) {
    std::error_code ignored;
    if (fs::is_directory(folder_ / name, ignored)) places.images.push_back(folder_ / name);
  }
  places.images.push_back(folder_);
  return places;
}

}  // namespace enfilade::scan
