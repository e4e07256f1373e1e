/// \file  Points drawn from triangles, uniformly by area.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/geometry/vec.h"

namespace enfilade {

/// Draws from a list of triangles. Immutable: any thread.
class TriangleDraw {
 public:
  /// \param triangles  in any order and orientation
  explicit TriangleDraw(std::vector<std::array<Vec3f, 3>> triangles)
      : triangles_(std::move(triangles)) {
    double sum = 0;
    for (const auto& [a, b, c] : triangles_) {
      sum += length(cross(to_double(b - a), to_double(c - a))) / 2;
      up_to_.push_back(sum);
    }
  }

  /// No value if there is no triangle.
  std::optional<Vec3f> draw(Rng& rng) const {
    if (triangles_.empty()) return std::nullopt;
    const double at = rng.uniform() * up_to_.back();
    const auto found = std::ranges::upper_bound(up_to_, at);
    const auto k = std::min(static_cast<std::size_t>(found - up_to_.begin()), up_to_.size() - 1);
    const auto& [a, b, c] = triangles_[k];
    // Uniform over the triangle: the square root makes up for its narrow end.
    const double out = std::sqrt(rng.uniform()), along = rng.uniform();
    return to_float(to_double(a) +
                    out * ((1 - along) * to_double(b - a) + along * to_double(c - a)));
  }

 private:
  std::vector<std::array<Vec3f, 3>> triangles_;
  std::vector<double> up_to_;  // area of the triangles up to each
};

}  // namespace enfilade
