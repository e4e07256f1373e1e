/// \file  Prefetching of the texels that a band of rows will read.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/render/cpu/row_plan.h"
#include "enfilade/render/face_cache.h"

namespace enfilade::render::cpu {

/// A row of a picture, cut into what lies on one face each.
struct PlannedRow {
  FaceLines lines;
  RowPlan plan;
};

/// The part of a face that a band of rows shows. Straight rows are straight on a face, so that the
/// part is convex and each row of texels in it a single run. Computed from some of the rows and
/// slightly too large: it only serves speed.
class Footprint {
 public:
  Footprint(std::span<const PlannedRow> rows, CubeFace face, std::uint32_t size);

  std::uint32_t size() const noexcept { return size_; }
  /// Loads all of it into the caches, run by run: neighbouring cache lines load several times as
  /// fast as the same lines in the order of pixels.
  void bring(const Face& face, std::size_t texel_bytes) const;

 private:
  struct Point {
    float x, y;
  };
  void add_edge(Point a, Point b);
  void add_row(const PlannedRow& row, CubeFace face);

  static constexpr std::size_t kLargest = 2048;  // texels; larger faces do without
  std::uint32_t size_;
  std::int32_t top_;  // rows of texels that have a run, both included
  std::int32_t bottom_ = -1;
  bool started_ = false;
  Point left_{}, right_{};  // ends of the row before
  std::array<float, kLargest> begin_, end_;
};

}  // namespace enfilade::render::cpu
