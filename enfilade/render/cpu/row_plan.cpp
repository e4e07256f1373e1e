#include "enfilade/render/cpu/row_plan.h"

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

ViewPlan::ViewPlan(const PixelRays& rays) : rays_(rays) {
  const Parts origin = parts_of(rays.origin), row = parts_of(rays.row);
  const Parts column = parts_of(rays.column);
  // Faces change where two parts of the direction are equal in size: a = b or a = -b.
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
    for (const double sign : {1.0, -1.0}) {
      const double slope = column[a] - sign * column[b];
      if (slope == 0) continue;  // no row crosses it
      crossings_[count_++] = {-(origin[a] - sign * origin[b]) / slope,
                              -(row[a] - sign * row[b]) / slope, a, c};
    }
  }
}

void ViewPlan::plan(std::uint32_t row, std::uint32_t width, Stretches& out) const {
  // Rounding must not hide a corner, where all three parts are equal; a cut too many does no harm.
  constexpr double kMargin = 1 + 1e-9;
  std::array<std::uint32_t, 8> cuts{};
  std::size_t n = 1;
  for (const Crossing& crossing : std::span(crossings_).first(count_)) {
    const double column = crossing.origin + row * crossing.slope;
    if (!(column > 0 && column < width)) continue;
    const Parts parts = parts_of(rays_.at(row, column));
    if (std::abs(parts[crossing.c]) > kMargin * std::abs(parts[crossing.a])) continue;
    const auto cut = static_cast<std::uint32_t>(std::ceil(column));
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
