/// \file  Cuts a picture into the pieces that lie on one face each.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/geometry/cube_map.h"

namespace enfilade::render::gl {

/// A point of a picture: pixels from its middle, x to the right, y down.
struct PicturePoint {
  double x = 0, y = 0;
};

/// A convex polygon. Each cut adds at most one corner to the picture's four.
class FacePiece {
 public:
  explicit FacePiece(const Camera& camera);
  /// Keeps what has c + x * a + y * b >= -margin * |(a, b)|: `margin` pixels more than the half.
  void cut(double c, double a, double b, double margin);
  std::span<const PicturePoint> corners() const noexcept { return {corners_.data(), count_}; }

 private:
  static constexpr std::size_t kMost = 8;
  std::array<PicturePoint, kMost> corners_{};
  std::size_t count_ = 0;
};

/// A pixel's ray on the axes of a face. For the pixel with its middle at (x, y), the parts along
/// right, down and forward are each c[0] + c[1] x + c[2] y.
struct FaceForms {
  std::array<double, 3> right{}, down{}, forward{};
};

FaceForms face_forms(const Camera& camera, const PixelRays& rays, CubeFace face);

/// The part of the picture that shows the face, and `margin` pixels around it.
FacePiece piece_of(const Camera& camera, const FaceForms& forms, double margin);

/// Finds the pixels with middles less than `distance` (< 0.5 pixels) from where two faces could
/// meet. A piece's edge is not exact enough there to decide the pixel's face. Returns their
/// middles.
void find_pixels_at_edges(const Camera& camera, const PixelRays& rays, double distance,
                          std::vector<PicturePoint>& pixels);

}  // namespace enfilade::render::gl
