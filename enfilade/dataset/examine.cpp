#include <fmt/format.h>

#include "enfilade/core/errors.h"
#include "enfilade/dataset/dataset.h"

namespace enfilade::dataset {
namespace {

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

std::string count_instructions(const r2r::Annotations& annotations) {
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

}  // namespace

std::vector<Part> Dataset::examine() const {
  std::vector<Part> parts;
  parts.push_back(look_for(
      "connectivity", [&] { return fmt::format("{} scans", graphs()->size()); },
      "copy connectivity/ of github.com/peteanderson80/Matterport3DSimulator into the folder"));
  for (const std::string_view split : kSplits) {
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
