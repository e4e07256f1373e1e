/// \file  Dynamic time warping of point sequences in space, exact and approximate.
#pragma once
#include <array>
#include <cstdint>
#include <span>

namespace enfilade::tasks {

/// x, y, z in metres.
using Point3 = std::array<double, 3>;

/// Least sum of Euclidean distances over alignments with steps (1, 0), (0, 1), (1, 1), both ends
/// tied; metres. O(|a| |b|). \pre neither is empty
double exact_dtw(std::span<const Point3> a, std::span<const Point3> b);

/// The two forms of the Python package `fastdtw`. They disagree. In the compiled one, the last row
/// of an odd list has the bounds of the row before. It allows no diagonal step beyond the end of
/// the row above. It breaks ties in another order.
enum class FastDtw : std::uint8_t { kPlain, kCompiled };

/// FastDTW (Salvador and Chan 2007) with radius 1, as that package computes it. Both lists are
/// halved until one has fewer than three points, and aligned. Then the alignment is refined in a
/// window around the coarser one. Never less than exact_dtw(). O(|a| + |b|).
/// \pre neither is empty
double fast_dtw(std::span<const Point3> a, std::span<const Point3> b, FastDtw form);

}  // namespace enfilade::tasks
