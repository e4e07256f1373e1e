/// \file  Feature files of numbers that are made, not computed.
#pragma once
#include <filesystem>
#include <functional>
#include <set>
#include <span>
#include <vector>

#include "enfilade/features/feature_set.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tests {

/// The included viewpoints of all buildings of these episodes.
inline std::vector<features::FeatureKey> keys_of(const tasks::EpisodeSet& episodes) {
  std::set<std::uint32_t> scans;
  std::vector<features::FeatureKey> keys;
  for (const tasks::ReferencePath& path : episodes.paths) {
    if (!scans.insert(path.scan.value).second) continue;
    const graph::NavGraph& graph = episodes.graphs->graph(path.scan);
    for (std::uint32_t v = 0; v < graph.size(); ++v) {
      const ViewpointIndex viewpoint(v);
      if (graph.included(viewpoint)) keys.push_back({graph.scan(), graph.id(viewpoint)});
    }
  }
  return keys;
}

/// \param fill writes the numbers of a viewpoint, (36, dimensions)
inline void write_feature_file(
    const std::filesystem::path& file, std::size_t dimensions,
    const std::vector<features::FeatureKey>& keys,
    const std::function<void(const features::FeatureKey&, std::span<float>)>& fill) {
  features::FeatureInfo info;
  info.dimensions = dimensions;
  features::FeatureWriter writer = features::FeatureWriter::create(file, info, keys);
  std::vector<float> numbers(info.views * dimensions);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    fill(keys[i], numbers);
    writer.write(i, numbers);
  }
  writer.finish();
}

}  // namespace enfilade::tests
