/// \file  Features of views, by the simulator's indices of scan, viewpoint and view.
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/graph/graph_set.h"
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

/// A table on a device with a row for each view that was used: each is sent there once. One thread
/// at a time.
class ResidentViews {
 public:
  static constexpr std::int64_t kViews = 36;   ///< rows of a viewpoint, by view
  static constexpr std::int64_t kNothing = 0;  ///< a row of zeros

  /// Writes the features of a viewpoint, (kViews, dimensions).
  using Source = std::function<void(graph::Location, std::span<float> out)>;

  ResidentViews(std::int64_t dimensions, c10::Device device, Source source);

  /// The row of a viewpoint's view 0; those of its other views follow.
  std::int64_t first_row(graph::Location location);
  /// (rows.size(), dimensions) on the device. No gradient.
  at::Tensor gather(const std::vector<std::int64_t>& rows);

 private:
  void send();

  std::int64_t dimensions_;
  c10::Device device_;
  Source source_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::int64_t> rows_;  // by scan and viewpoint
  std::int64_t used_ = 1;       // rows of the table that are there, or queued for sending
  std::vector<float> to_send_;  // of the last rows
  at::Tensor table_;            // (at least used_, dimensions)
};

}  // namespace enfilade::neural::core
