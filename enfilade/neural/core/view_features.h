/// \file  Features of views, by the simulator's indices of scan, viewpoint and view.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::neural::core {

/// A FeatureSet whose viewpoints were looked up once. Immutable: any thread may read. Copies share
/// their data.
class ViewFeatures {
 public:
  static constexpr std::size_t kViews = 36;  ///< per viewpoint: 12 headings, 3 elevations

  /// Looks up each included viewpoint of each scan that `episodes` use; reads their graphs.
  /// \throws InvalidInput if the set has not kViews views per viewpoint, or naming the viewpoints
  /// that are missing; errors of graph files
  ViewFeatures(features::FeatureSet features, const tasks::EpisodeSet& episodes);

  std::size_t dimensions() const noexcept { return features_.info().dimensions; }
  ScanIndex scan(std::string_view name) const { return graphs_->at(name); }  ///< for copy()
  /// Copies the features of view `view` (StateSpans::view_index) of an included viewpoint.
  /// \pre the scan is one of the episodes', out.size() == dimensions()
  void copy(ScanIndex scan, ViewpointIndex viewpoint, std::uint32_t view,
            std::span<float> out) const {
    features_.copy_view(rows_[scan.at()][viewpoint.at()], view, out);
  }

 private:
  features::FeatureSet features_;
  std::shared_ptr<const graph::GraphSet> graphs_;
  std::vector<std::vector<std::uint32_t>> rows_;  // by scan, by viewpoint; empty: not in use
};

}  // namespace enfilade::neural::core
