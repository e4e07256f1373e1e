/// \file  Plain reference implementations of the simulator's fast loops, for its tests. Both agree
/// to the bit.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "enfilade/geometry/angle.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/sim/simulator.h"

namespace enfilade::tests {

/// s_atanf.c of glibc 2.36, with its branches; x >= 0. Its notice is in atan2f.h.
inline float reference_atanf(float x) {
  constexpr std::array<float, 4> kHigh{0x1.dac67p-2F, 0x1.921fb4p-1F, 0x1.f730bcp-1F,
                                       0x1.921fb4p0F};
  constexpr std::array<float, 4> kLow{0x1.586ed2p-28F, 0x1.4442dp-25F, 0x1.281f68p-25F,
                                      0x1.4442dp-24F};
  constexpr std::array<float, 11> kA{3.3333334327e-01F,  -2.0000000298e-01F, 1.4285714924e-01F,
                                     -1.1111110449e-01F, 9.0908870101e-02F,  -7.6918758452e-02F,
                                     6.6610731184e-02F,  -5.8335702866e-02F, 4.9768779427e-02F,
                                     -3.6531571299e-02F, 1.6285819933e-02F};
  if (x >= 0x1p25F) return kHigh[3] + kLow[3];
  int interval = -1;
  if (x >= 2.4375F) {
    interval = 3;
    x = -1.0F / x;
  } else if (x >= 1.1875F) {
    interval = 2;
    x = (x - 1.5F) / (1.0F + 1.5F * x);
  } else if (x >= 0.6875F) {
    interval = 1;
    x = (x - 1.0F) / (x + 1.0F);
  } else if (x >= 0.4375F) {
    interval = 0;
    x = (2.0F * x - 1.0F) / (2.0F + x);
  }
  const float z = x * x;
  const float w = z * z;
  const float s1 = z * (kA[0] + w * (kA[2] + w * (kA[4] + w * (kA[6] + w * (kA[8] + w * kA[10])))));
  const float s2 = w * (kA[1] + w * (kA[3] + w * (kA[5] + w * (kA[7] + w * kA[9]))));
  if (interval < 0) return x - x * (s1 + s2);
  const auto i = static_cast<std::size_t>(interval);
  return kHigh[i] - ((x * (s1 + s2) - kLow[i]) - x);
}

/// e_atan2f.c of the same, for finite numbers.
inline float reference_atan2f(float y, float x) {
  constexpr float kPiHere = 3.1415927410F;
  constexpr float kPiLow = -8.7422776573e-08F;
  if (y == 0) return std::signbit(x) ? std::copysign(kPiHere, y) : y;
  if (x == 0) return std::copysign(1.5707963705F, y);
  const int exponents =
      (std::bit_cast<std::int32_t>(std::abs(y)) - std::bit_cast<std::int32_t>(std::abs(x))) >> 23;
  float z = 0;
  if (exponents > 60) {
    z = 1.5707963705F + 0.5F * kPiLow;
  } else if (!(x < 0 && exponents < -60)) {
    z = reference_atanf(std::abs(y / x));
  }
  if (x < 0) z = kPiHere - (z - kPiLow);
  return y < 0 ? -z : z;
}

struct ReferenceNavigable {
  ViewpointIndex viewpoint;
  double rel_heading = 0, rel_elevation = 0, distance = 0;
  friend bool operator==(const ReferenceNavigable&, const ReferenceNavigable&) = default;
};

/// The viewpoints that are navigable from `here` with `heading` and `elevation`; \p half_width is
/// half the field of view.
inline std::vector<ReferenceNavigable> reference_navigable(const graph::NavGraph& graph,
                                                           ViewpointIndex here, double heading,
                                                           double elevation, bool restricted,
                                                           double half_width) {
  const auto camera_x = static_cast<float>(std::cos(kPi / 2 - heading));
  const auto camera_y = static_cast<float>(std::sin(kPi / 2 - heading));
  std::vector<ReferenceNavigable> list{{here, 0, 0, 0}};
  for (const graph::Edge& edge : graph.edges(here)) {
    const float cosine = edge.unit_x * camera_x + edge.unit_y * camera_y;
    if (restricted && !(static_cast<double>(cosine) >= std::cos(half_width))) continue;
    const float angle = reference_atan2f(edge.dx * camera_y - edge.dy * camera_x,
                                         edge.dx * camera_x + edge.dy * camera_y);
    list.push_back({edge.target, static_cast<double>(angle), edge.elevation.value - elevation,
                    static_cast<double>(edge.distance)});
  }
  // Targets come in ascending order, so that a stable sort leaves ties by viewpoint.
  std::stable_sort(list.begin() + 1, list.end(), [](const auto& a, const auto& b) {
    const auto key = [](const ReferenceNavigable& n) {
      return std::sqrt(n.rel_heading * n.rel_heading + n.rel_elevation * n.rel_elevation);
    };
    return key(a) < key(b);
  });
  return list;
}

}  // namespace enfilade::tests
