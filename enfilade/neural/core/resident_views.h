/// \file  Features of views that stay on a card.
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "enfilade/graph/graph_set.h"

namespace enfilade::neural::core {

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
