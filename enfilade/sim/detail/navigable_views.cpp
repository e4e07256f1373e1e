#include "enfilade/sim/detail/navigable_views.h"

#include <cmath>

#include "enfilade/sim/detail/atan2f.h"

namespace enfilade::sim::detail {
namespace {

constexpr std::size_t kLanes = 8;  // loops run over whole blocks, so that compilers unroll them

constexpr std::size_t whole_blocks(std::size_t n) { return (n + kLanes - 1) / kLanes * kLanes; }

void compute_headings(const float* __restrict right, const float* __restrict ahead,
                      float* __restrict heading) {
  for (std::size_t i = 0; i < kLanes; ++i) heading[i] = atan2f_fdlibm(right[i], ahead[i]);
}

void compute_order(const float* __restrict heading, const double* __restrict elevation,
                   double* __restrict order) {
  for (std::size_t i = 0; i < kLanes; ++i) {
    const double h = heading[i];
    order[i] = std::sqrt(h * h + elevation[i] * elevation[i]);
  }
}

}  // namespace

NavigableViews::NavigableViews(std::size_t agents, std::size_t max_navigable) : ends_(agents) {
  const std::size_t capacity = whole_blocks(agents * max_navigable);
  for (auto* column : {&right_, &ahead_, &rel_heading_, &distance_}) column->resize(capacity);
  for (auto* column : {&rel_elevation_, &order_}) column->resize(capacity);
  target_.resize(capacity);
  rank_.resize(max_navigable);
}

void NavigableViews::clear() noexcept { agents_ = written_ = size_ = 0; }

void NavigableViews::add(std::span<const graph::Edge> edges, Direction camera, double elevation,
                         const ViewLimit& limit) {
  std::size_t n = size_;
  for (const graph::Edge& edge : edges) {
    const float cosine = edge.unit_x * camera.x + edge.unit_y * camera.y;
    right_[n] = edge.dx * camera.y - edge.dy * camera.x;
    ahead_[n] = edge.dx * camera.x + edge.dy * camera.y;
    rel_elevation_[n] = edge.elevation.value - elevation;
    distance_[n] = edge.distance;
    target_[n] = edge.target.value;
    // An edge out of view is overwritten by the next one: a branch would be mispredicted every
    // other time.
    const bool in_view = static_cast<double>(cosine) >= limit.min_cosine;  // false for NaN
    n += static_cast<std::size_t>(limit.all | in_view);
  }
  size_ = n;
  ends_[agents_++] = static_cast<std::uint32_t>(n);
}

void NavigableViews::compute() {
  for (std::size_t i = 0; i < size_; i += kLanes) {
    compute_headings(&right_[i], &ahead_[i], &rel_heading_[i]);
    compute_order(&rel_heading_[i], &rel_elevation_[i], &order_[i]);
  }
}

std::uint32_t NavigableViews::write(ViewpointIndex here, const NavigableRow& row) {
  const std::size_t begin = written_ == 0 ? 0 : ends_[written_ - 1];
  const std::size_t n = ends_[written_++] - begin;
  // Counting for each neighbour how many come before it takes n^2 / 2 comparisons and no
  // unpredictable branch: for the five neighbours of a viewpoint that is faster than sorting.
  // Neighbours come by rising index, so that on a tie the earlier one stays in front.
  const double* order = &order_[begin];
  std::uint32_t* rank = rank_.data();
  for (std::size_t i = 0; i < n; ++i) {
    std::uint32_t ahead = 1;  // entry 0 is the present viewpoint
    for (std::size_t j = 0; j < i; ++j) {
      const auto before = static_cast<std::uint32_t>(order[i] < order[j]);
      rank[j] += before;
      ahead += 1 - before;
    }
    rank[i] = ahead;
  }
  row.target[0] = here.value;
  row.viewpoint[0] = here;
  row.rel_heading[0] = row.rel_elevation[0] = row.distance[0] = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t place = rank[i];
    row.target[place] = target_[begin + i];
    row.viewpoint[place].value = target_[begin + i];
    row.rel_heading[place] = static_cast<double>(rel_heading_[begin + i]);
    row.rel_elevation[place] = rel_elevation_[begin + i];
    row.distance[place] = static_cast<double>(distance_[begin + i]);
  }
  return static_cast<std::uint32_t>(n + 1);
}

}  // namespace enfilade::sim::detail
