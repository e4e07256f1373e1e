#include "enfilade/render/cpu/row_plan.h"

#include <algorithm>
#include <cmath>

#include "enfilade/core/check.h"

namespace enfilade::render::cpu {
namespace {

// The part of a direction along an axis that is a unit vector, as all of kFaceAxes are.
struct Axis {
  std::size_t part;
  double sign;
};

constexpr Axis axis_of(Vec3d v) {
  if (v.x != 0) return {0, v.x};
  if (v.y != 0) return {1, v.y};
  return {2, v.z};
}

struct Axes {
  Axis right, down, forward;
};

constexpr std::array<Axes, kCubeFaces> kAxes = [] {
  std::array<Axes, kCubeFaces> axes{};
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const FaceAxes& face = kFaceAxes[k];
    axes[k] = {axis_of(face.right), axis_of(face.down), axis_of(face.forward)};
  }
  return axes;
}();

using Parts = std::array<double, 3>;
Parts parts_of(Vec3d v) { return {v.x, v.y, v.z}; }

// origin + row * slope
struct Linear {
  double origin, slope;
  double at(double row) const { return origin + row * slope; }
};

constexpr double kMostRows = 1U << 31U;

std::uint32_t row_number(double row) {
  return static_cast<std::uint32_t>(std::clamp(row, 0.0, kMostRows));
}

}  // namespace

void Stretches::add(std::uint32_t begin, std::uint32_t end, CubeFace face) {
  if (count_ > 0 && stretches_[count_ - 1].face == face) {
    stretches_[count_ - 1].end = end;
    return;
  }
  EN_CHECK_LT(count_, stretches_.size());
  stretches_[count_++] = {begin, end, face};
}

FaceLine face_line(const PixelRays& rays, std::uint32_t row, CubeFace face, std::uint32_t size) {
  const Axes& axes = kAxes[index(face)];
  const Parts origin = parts_of(rays.at(row, 0)), column = parts_of(rays.column);
  const double half = size * 32768.0, middle = half + 32768.0;
  const auto start = [&](Axis axis) { return axis.sign * origin[axis.part]; };
  const auto step = [&](Axis axis) { return axis.sign * column[axis.part]; };
  const double d0 = start(axes.forward), d1 = step(axes.forward);
  return {static_cast<float>(start(axes.right) * half + d0 * middle),
          static_cast<float>(step(axes.right) * half + d1 * middle),
          static_cast<float>(start(axes.down) * half + d0 * middle),
          static_cast<float>(step(axes.down) * half + d1 * middle),
          static_cast<float>(d0),
          static_cast<float>(d1)};
}

// The rows in which |part| <= |limit|, and perhaps one more at each end: a cut too many does no
// harm, and rounding must not hide a corner, where both are equal.
std::array<ViewPlan::Rows, 2> ViewPlan::rows_within(double part0, double part1, double limit0,
                                                    double limit1) {
  const std::array<Linear, 2> factors{Linear{limit0 - part0, limit1 - part1},
                                      Linear{limit0 + part0, limit1 + part1}};
  std::array<double, 2> roots{0, 0};
  for (std::size_t k = 0; k < 2; ++k) {
    if (factors[k].slope != 0) roots[k] = -factors[k].origin / factors[k].slope;
  }
  std::array<double, 4> ends{0, roots[0], roots[1], kMostRows};
  std::ranges::sort(ends);
  std::array<Rows, 2> rows{};
  std::size_t count = 0;
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    const double begin = std::max(ends[k], 0.0), end = std::min(ends[k + 1], kMostRows);
    const double middle = begin + (end - begin) / 2;
    if (begin > end || factors[0].at(middle) * factors[1].at(middle) < 0) continue;
    const Rows found{row_number(std::floor(begin) - 1), row_number(std::ceil(end) + 2)};
    if (count > 0 && found.begin <= rows[count - 1].end) {
      rows[count - 1].end = found.end;
    } else {
      rows[count++] = found;
    }
  }
  return rows;
}

ViewPlan::ViewPlan(const PixelRays& rays) : rays_(rays) {
  const Parts origin = parts_of(rays.origin), row = parts_of(rays.row);
  const Parts column = parts_of(rays.column);
  // Faces change where two parts of the direction are equal in size: a = b or a = -b.
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
    for (const double sign : {1.0, -1.0}) {
      const double slope = column[a] - sign * column[b];
      if (slope == 0) continue;  // no row crosses it
      const Linear at{-(origin[a] - sign * origin[b]) / slope, -(row[a] - sign * row[b]) / slope};
      crossings_[count_++] = {
          at.origin, at.slope,
          rows_within(origin[c] + at.origin * column[c], row[c] + at.slope * column[c],
                      origin[a] + at.origin * column[a], row[a] + at.slope * column[a])};
    }
  }
}

void ViewPlan::plan(std::uint32_t row, std::uint32_t width, Stretches& out) const {
  std::array<std::uint32_t, 8> cuts{};
  std::size_t n = 1;
  for (const Crossing& crossing : std::span(crossings_).first(count_)) {
    if (!crossing.rows[0].have(row) && !crossing.rows[1].have(row)) continue;
    const double column = crossing.origin + row * crossing.slope;
    if (!(column > 0 && column < width)) continue;
    auto cut = static_cast<std::uint32_t>(column);
    if (cut < column) ++cut;
    // Kept in order: six numbers at most, too few for a sorting function.
    std::size_t k = n++;
    for (; cuts[k - 1] > cut; --k) cuts[k] = cuts[k - 1];
    cuts[k] = cut;
  }
  out.count_ = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t begin = cuts[k], end = k + 1 < n ? cuts[k + 1] : width;
    if (begin >= end) continue;
    out.add(begin, end, face_towards(rays_.at(row, begin + (end - begin) / 2)));
  }
}

}  // namespace enfilade::render::cpu
