#include "enfilade/sim/detail/navigable_views.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

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

void NavigableViews::add(std::span<const graph::Edge> edges, FloorDirection camera,
                         double elevation, const ViewLimit& limit) {
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

namespace {

// compute_sincos() is off by less than 4e-16 (three roundings of numbers up to 1, and the terms
// that the series leaves out), the C library by less than 2e-16. This is twice their sum: if value
// - kMargin and value + kMargin round to the same float, direction_of() rounds to it too.
constexpr double kMargin = 1.2e-15;

double with_sign_of_bit_1(double value, std::int64_t bits) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) ^
                               ((static_cast<std::uint64_t>(bits) & 2U) << 62U));
}

struct SinCos {
  double sin, cos;
};

// For |angle| <= 2 pi. No branches: a loop over it runs in vector registers.
SinCos compute_sincos(double angle) {
  // The nearest multiple of pi/2 is taken off, in two parts of which the first has so few digits
  // that its multiples are exact. Adding 1.5 * 2^52 rounds, and leaves the multiple's last bits.
  constexpr double kRounder = 0x1.8p52;
  constexpr double kHalfPiHigh = 0x1.921fb544p0;
  constexpr double kHalfPiLow = 0x1.0b4611a626331p-34;
  const double rounded = angle * (2 / kPi) + kRounder;
  const auto quadrant = std::bit_cast<std::int64_t>(rounded);
  const double multiple = rounded - kRounder;
  const double r = (angle - multiple * kHalfPiHigh) - multiple * kHalfPiLow;

  // Taylor's series; |r| <= pi/4, so that the first term left out is below 5e-17.
  const double z = r * r;
  const double sin_r = r + r * z *
                               polynomial(z, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880,
                                          -1.0 / 39916800, 1.0 / 6227020800, -1.0 / 1307674368000);
  const double cos_r =
      1 + z * polynomial(z, -1.0 / 2, 1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800,
                         1.0 / 479001600, -1.0 / 87178291200, 1.0 / 20922789888000);
  const std::int64_t odd = -(quadrant & 1);
  return {with_sign_of_bit_1(select(odd, cos_r, sin_r), quadrant),
          with_sign_of_bit_1(select(odd, sin_r, cos_r), quadrant + 1)};
}

// 0 if the rounded value is sure.
std::uint32_t doubt(double value) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(value - kMargin)) ^
         std::bit_cast<std::uint32_t>(static_cast<float>(value + kMargin));
}

}  // namespace

FloorDirection direction_of(Radians heading) {
  const double angle = kPi / 2 - heading.value;
  return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
}

void compute_directions(std::span<const double> headings, std::span<FloorDirection> out) {
  for (std::size_t begin = 0; begin < headings.size(); begin += kLanes) {
    const std::size_t n = std::min(kLanes, headings.size() - begin);
    std::array<double, kLanes> angle{};
    std::array<float, kLanes> x, y;
    std::array<std::uint32_t, kLanes> doubts;
    for (std::size_t i = 0; i < n; ++i) angle[i] = kPi / 2 - headings[begin + i];
    for (std::size_t i = 0; i < kLanes; ++i) {
      const SinCos value = compute_sincos(angle[i]);
      x[i] = static_cast<float>(value.cos);
      y[i] = static_cast<float>(value.sin);
      doubts[i] = doubt(value.cos) | doubt(value.sin);
    }
    for (std::size_t i = 0; i < n; ++i) {
      out[begin + i] =
          doubts[i] == 0 ? FloorDirection{x[i], y[i]} : direction_of(Radians(headings[begin + i]));
    }
  }
}

}  // namespace enfilade::sim::detail
