#include "enfilade/neural/core/view_features.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::neural::core {
namespace {

constexpr std::size_t kNamed = 5;  // missing viewpoints that a message names

std::vector<std::uint32_t> rows_of(const features::FeatureSet& features,
                                   const graph::NavGraph& graph,
                                   std::vector<std::string>& missing) {
  std::vector<std::uint32_t> rows(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex viewpoint(i);
    if (!graph.included(viewpoint)) continue;
    const auto row = features.row(graph.scan(), graph.id(viewpoint));
    if (row) {
      rows[i] = static_cast<std::uint32_t>(*row);
    } else {
      missing.push_back(graph.scan() + "_" + graph.id(viewpoint));
    }
  }
  return rows;
}

}  // namespace

ViewFeatures::ViewFeatures(features::FeatureSet features, const tasks::EpisodeSet& episodes)
    : features_(std::move(features)), graphs_(episodes.graphs), rows_(episodes.graphs->size()) {
  if (features_.info().views != kViews) {
    refuse("features", "", "wrong-views",
           fmt::format("{} views a viewpoint, not {}", features_.info().views, kViews));
  }
  std::vector<std::string> missing;
  for (const tasks::ReferencePath& path : episodes.paths) {
    std::vector<std::uint32_t>& rows = rows_[path.scan.at()];
    if (rows.empty()) rows = rows_of(features_, episodes.graphs->graph(path.scan), missing);
  }
  if (missing.empty()) return;
  const std::size_t count = missing.size();
  if (count > kNamed) missing.resize(kNamed);
  refuse("features", "", "missing-viewpoints",
         fmt::format("none for {} viewpoints that agents may come to in split {}: {}{}", count,
                     episodes.split, fmt::join(missing, ", "), count > kNamed ? ", ..." : ""));
}

}  // namespace enfilade::neural::core
