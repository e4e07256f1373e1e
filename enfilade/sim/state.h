/// \file  The state of a batch of agents, as arrays.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/core/ids.h"

namespace enfilade::sim {

/// The state of n = batch agents. One array per quantity, shape (batch); for navigable viewpoints,
/// shape (batch, max_navigable), row-major. Row k of `navigable_*` is filled up to
/// navigable_count[k]; the rest is not changed. Entry 0 is the present viewpoint with zeros. The
/// others follow by rising sqrt(rel_heading^2 + rel_elevation^2), ties by viewpoint.
struct StateSpans {
  std::span<ScanIndex> scan;
  std::span<ViewpointIndex> viewpoint;
  std::span<double> heading;            ///< radians, [0, 2 pi]
  std::span<double> elevation;          ///< radians
  std::span<std::uint32_t> view_index;  ///< 0..35 = 12 * row (down, level, up) + heading step;
                                        ///< 0 if viewing is continuous
  std::span<std::uint32_t> step;        ///< actions since the start
  std::span<std::uint32_t> navigable_count;
  std::span<ViewpointIndex> navigable_viewpoint;
  std::span<double> navigable_rel_heading;    ///< radians from the view's middle, right positive
  std::span<double> navigable_rel_elevation;  ///< radians from the view's middle, up positive
  std::span<double> navigable_distance;       ///< metres, straight line

  std::size_t batch_size() const noexcept { return scan.size(); }
  /// Columns of navigable_*. \pre batch_size() > 0
  std::size_t max_navigable() const noexcept { return navigable_viewpoint.size() / scan.size(); }
};

/// Memory for a StateSpans, for callers who keep more than one state of a simulator. A plain value.
class StateBuffer {
 public:
  /// For `batch_size` agents with `max_navigable` entries in each navigable list.
  StateBuffer(std::size_t batch_size, std::size_t max_navigable);
  StateSpans spans() noexcept;  ///< valid as long as *this, until it is moved or assigned to

 private:
  std::vector<ScanIndex> scan_;
  std::vector<ViewpointIndex> viewpoint_;
  std::vector<double> heading_, elevation_;
  std::vector<std::uint32_t> view_index_, step_, navigable_count_;
  std::vector<ViewpointIndex> navigable_viewpoint_;
  std::vector<double> navigable_rel_heading_, navigable_rel_elevation_, navigable_distance_;
};

}  // namespace enfilade::sim
