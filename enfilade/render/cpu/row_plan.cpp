#include "enfilade/render/cpu/row_plan.h"

#include <cmath>

#include "enfilade/core/check.h"

namespace enfilade::render::cpu {

FaceLines face_lines(const PixelRays& rays, std::uint32_t row) {
  const Vec3d origin = rays.at(row, 0);
  FaceLines lines;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const FaceAxes& axes = kFaceAxes[k];
    lines[k] = {static_cast<float>(dot(axes.right, origin)),
                static_cast<float>(dot(axes.right, rays.column)),
                static_cast<float>(dot(axes.down, origin)),
                static_cast<float>(dot(axes.down, rays.column)),
                static_cast<float>(dot(axes.forward, origin)),
                static_cast<float>(dot(axes.forward, rays.column))};
  }
  return lines;
}

RowPlan::RowPlan(const PixelRays& rays, std::uint32_t row, std::uint32_t width) {
  const Vec3d origin = rays.at(row, 0);
  const std::array<double, 3> start{origin.x, origin.y, origin.z};
  const std::array<double, 3> step{rays.column.x, rays.column.y, rays.column.z};
  std::array<std::uint32_t, 8> cuts{};
  std::size_t n = 0;
  cuts[n++] = 0;
  // Kept in order: six numbers at most, too few for a sorting function.
  const auto cut = [&](double constant, double slope) {
    const double column = -constant / slope;
    if (!(column > 0 && column < width)) return;
    const auto at = static_cast<std::uint32_t>(std::ceil(column));
    std::size_t k = n++;
    for (; cuts[k - 1] > at; --k) cuts[k] = cuts[k - 1];
    cuts[k] = at;
  };
  // Faces change where two parts of the direction are equal in size: a = b or a = -b.
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = (a + 1) % 3;
    cut(start[a] - start[b], step[a] - step[b]);
    cut(start[a] + start[b], step[a] + step[b]);
  }
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t end = k + 1 < n ? cuts[k + 1] : width;
    if (cuts[k] < end) add_piece(rays, row, cuts[k], end);
  }
}

// Rounding may put the pixel at a cut on the wrong side: the middle pixel decides the face of the
// stretch, and the pixels at both ends are tested themselves.
void RowPlan::add_piece(const PixelRays& rays, std::uint32_t row, std::uint32_t begin,
                        std::uint32_t end) {
  const auto face_at = [&](std::uint32_t column) { return face_towards(rays.at(row, column)); };
  const CubeFace face = face_at(begin + (end - begin) / 2);
  const CubeFace first = face_at(begin), last = face_at(end - 1);
  if (first != face) {
    add(begin, begin + 1, first);
    ++begin;
  }
  const std::uint32_t inner = last != face ? end - 1 : end;
  if (begin < inner) add(begin, inner, face);
  if (inner < end && inner >= begin) add(inner, end, last);
}

void RowPlan::add(std::uint32_t begin, std::uint32_t end, CubeFace face) {
  if (count_ > 0 && stretches_[count_ - 1].face == face) {
    stretches_[count_ - 1].end = end;
    return;
  }
  EN_CHECK_LT(count_, stretches_.size());
  stretches_[count_++] = {begin, end, face};
}

}  // namespace enfilade::render::cpu
