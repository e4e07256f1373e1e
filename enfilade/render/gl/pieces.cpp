#include "enfilade/render/gl/pieces.h"

#include <algorithm>
#include <cmath>

#include "enfilade/core/check.h"

namespace enfilade::render::gl {
namespace {

// Middles of pixels near the line c + x * a + y * b = 0, which is no flatter than steep: it passes
// each row once. `flip`: x and y are exchanged.
void add_along(double c, double a, double b, double width, double height, double distance,
               bool flip, std::vector<PicturePoint>& pixels) {
  const double reach = distance * std::hypot(a, b) / std::abs(a);
  for (double y = (1 - height) / 2; y < height / 2; ++y) {
    const double crossing = -(c + b * y) / a;
    const double x = std::floor(crossing + width / 2) + (1 - width) / 2;
    if (std::abs(x - crossing) > reach || std::abs(x) > width / 2) continue;
    pixels.push_back(flip ? PicturePoint{y, x} : PicturePoint{x, y});
  }
}

// Whether the line passes through the picture.
bool meets(const std::array<double, 3>& line, double width, double height) {
  const double reach = std::abs(line[1]) * width / 2 + std::abs(line[2]) * height / 2;
  return std::abs(line[0]) <= reach;
}

// The part along `axis` of a pixel's ray, as in FaceForms.
std::array<double, 3> form_along(Vec3d axis, const Camera& camera, const PixelRays& rays) {
  const Vec3d middle = rays.at((camera.height - 1) / 2.0, (camera.width - 1) / 2.0);
  return {dot(axis, middle), dot(axis, rays.column), dot(axis, rays.row)};
}

}  // namespace

FacePiece::FacePiece(const Camera& camera) : count_(4) {
  const double x = camera.width / 2.0, y = camera.height / 2.0;
  corners_ = {{{-x, -y}, {x, -y}, {x, y}, {-x, y}}};
}

void FacePiece::cut(double c, double a, double b, double margin) {
  const double offset = c + margin * std::hypot(a, b);
  const auto side = [&](PicturePoint p) { return offset + a * p.x + b * p.y; };
  const std::array<PicturePoint, kMost> before = corners_;
  const std::size_t n = count_;
  count_ = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const PicturePoint from = before[k], to = before[(k + 1) % n];
    const double here = side(from), there = side(to);
    if (here >= 0) corners_[count_++] = from;
    if ((here >= 0) != (there >= 0)) {
      const double u = here / (here - there);
      corners_[count_++] = {from.x + u * (to.x - from.x), from.y + u * (to.y - from.y)};
    }
    EN_CHECK_LE(count_, kMost);
  }
}

FaceForms face_forms(const Camera& camera, const PixelRays& rays, CubeFace face) {
  const FaceAxes& axes = kFaceAxes[index(face)];
  const auto form = [&](Vec3d axis) { return form_along(axis, camera, rays); };
  return {form(axes.right), form(axes.down), form(axes.forward)};
}

FacePiece piece_of(const Camera& camera, const FaceForms& forms, double margin) {
  FacePiece piece(camera);
  const auto& w = forms.forward;
  for (const auto& side : {forms.right, forms.down}) {
    piece.cut(w[0] + side[0], w[1] + side[1], w[2] + side[2], margin);
    piece.cut(w[0] - side[0], w[1] - side[1], w[2] - side[2], margin);
  }
  return piece;
}

void find_pixels_at_edges(const Camera& camera, const PixelRays& rays, double distance,
                          std::vector<PicturePoint>& pixels) {
  pixels.clear();
  constexpr std::array<Vec3d, 6> kDiagonals{
      {{1, 1, 0}, {1, -1, 0}, {1, 0, 1}, {1, 0, -1}, {0, 1, 1}, {0, 1, -1}}};
  const double width = camera.width, height = camera.height;
  for (const Vec3d& diagonal : kDiagonals) {
    const std::array<double, 3> line = form_along(diagonal, camera, rays);
    if (!meets(line, width, height)) continue;
    if (std::abs(line[1]) >= std::abs(line[2])) {
      add_along(line[0], line[1], line[2], width, height, distance, false, pixels);
    } else {
      add_along(line[0], line[2], line[1], height, width, distance, true, pixels);
    }
  }
  // A line goes on beyond the cube's edge, over a third face that lies before both.
  const double step = length(rays.column) + length(rays.row);
  std::erase_if(pixels, [&](PicturePoint p) {
    const Vec3d ray = rays.at(p.y + (height - 1) / 2, p.x + (width - 1) / 2);
    std::array<double, 3> parts{std::abs(ray.x), std::abs(ray.y), std::abs(ray.z)};
    std::ranges::sort(parts);
    return parts[2] - parts[1] > step;
  });
}

}  // namespace enfilade::render::gl
