#include "enfilade/geometry/cube_map.h"

#include <algorithm>

#include "enfilade/core/check.h"

namespace enfilade {
namespace {

// Whether the middle of a face is inside the picture's cone.
bool sees_middle(CubeFace face, const Camera& camera, const Mat3d& camera_from_panorama) {
  const Vec3d eye = camera_from_panorama * kFaceAxes[index(face)].forward;
  const double y = std::tan(camera.vertical_field_of_view.value / 2);
  const double x = y * camera.width / camera.height;
  return eye.z > 0 && std::abs(eye.x) <= x * eye.z && std::abs(eye.y) <= y * eye.z;
}

// The faces that the directions from + u (to - from), u in [0, 1], hit. Where two faces meet, two
// components of the direction have equal size, which is linear in u for each pair and sign.
std::uint8_t faces_along(Vec3d from, Vec3d to) {
  constexpr double kMargin = 1e-9;  // both sides of an edge count if a line runs along it
  const Vec3d step = to - from;
  const auto change = [](double a, double b) { return b == 0 ? -1.0 : -a / b; };
  std::array<double, 8> at{0,
                           1,
                           change(from.x - from.y, step.x - step.y),
                           change(from.x + from.y, step.x + step.y),
                           change(from.x - from.z, step.x - step.z),
                           change(from.x + from.z, step.x + step.z),
                           change(from.y - from.z, step.y - step.z),
                           change(from.y + from.z, step.y + step.z)};
  for (double& u : at) u = std::clamp(u, 0.0, 1.0);
  std::ranges::sort(at);
  std::uint8_t mask = 0;
  const auto mark = [&](Vec3d d) {
    const double largest = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      if (dot(kFaceAxes[k].forward, d) >= largest * (1 - kMargin)) {
        mask = static_cast<std::uint8_t>(mask | 1U << k);
      }
    }
  };
  for (std::size_t k = 0; k < at.size(); ++k) {
    mark(from + at[k] * step);
    if (k > 0) mark(from + (at[k - 1] + at[k]) / 2 * step);
  }
  return mask;
}

}  // namespace

Vec3d cube_direction(CubeFace face, double s, double t) {
  const FaceAxes& axes = kFaceAxes[index(face)];
  return axes.forward + (2 * s - 1) * axes.right + (2 * t - 1) * axes.down;
}

FacePoint project_to_cube(Vec3d d) {
  const CubeFace face = face_towards(d);
  const FaceAxes& axes = kFaceAxes[index(face)];
  const double ahead = dot(axes.forward, d);
  EN_CHECK(ahead > 0);
  return {face, (dot(axes.right, d) / ahead + 1) / 2, (dot(axes.down, d) / ahead + 1) / 2};
}

Mat3d world_from_camera(Radians heading, Radians elevation) {
  const double sh = std::sin(heading.value), ch = std::cos(heading.value);
  const double se = std::sin(elevation.value), ce = std::cos(elevation.value);
  const Vec3d right{ch, -sh, 0}, down{sh * se, ch * se, -ce}, forward{sh * ce, ch * ce, se};
  return {{right.x, down.x, forward.x, right.y, down.y, forward.y, right.z, down.z, forward.z}};
}

PixelRays pixel_rays(const Camera& camera, const Mat3d& frame_from_camera) {
  const double y = std::tan(camera.vertical_field_of_view.value / 2);
  const double pixel = 2 * y / camera.height;  // square pixels: also across
  const auto [width, height] = std::pair<double, double>(camera.width, camera.height);
  return {frame_from_camera * Vec3d{(1 - width) / 2 * pixel, (1 - height) / 2 * pixel, 1},
          frame_from_camera * Vec3d{0, pixel, 0}, frame_from_camera * Vec3d{pixel, 0, 0}};
}

std::uint8_t faces_in_view(const Camera& camera, const Mat3d& panorama_from_camera) {
  const double y = std::tan(camera.vertical_field_of_view.value / 2);
  const double x = y * camera.width / camera.height;
  const std::array<Vec3d, 4> corners{
      panorama_from_camera * Vec3d{-x, -y, 1}, panorama_from_camera * Vec3d{x, -y, 1},
      panorama_from_camera * Vec3d{x, y, 1}, panorama_from_camera * Vec3d{-x, y, 1}};
  std::uint8_t mask = 0;
  for (std::size_t k = 0; k < 4; ++k) mask |= faces_along(corners[k], corners[(k + 1) % 4]);
  // A face that meets the picture but not its outline is entirely inside, and so is its middle.
  const Mat3d camera_from_panorama = transpose(panorama_from_camera);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    if (sees_middle(cube_face(k), camera, camera_from_panorama)) {
      mask = static_cast<std::uint8_t>(mask | 1U << k);
    }
  }
  return mask;
}

}  // namespace enfilade
