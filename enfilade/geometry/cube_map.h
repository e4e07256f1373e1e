/// \file  Cube maps: the six faces of a panorama, their directions, and the faces that a camera
/// sees.
///
/// Panorama frame: that of Matterport3D's poses, x right, y down, z forward, the eye at the origin;
/// "forward" is the middle of face 3. See docs/conventions.md.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "enfilade/geometry/camera.h"
#include "enfilade/geometry/vec.h"

namespace enfilade {

/// In Matterport3D's order: `<viewpoint>_skybox<k>_sami.jpg`, and left to right in a strip.
enum class CubeFace : std::uint8_t { kUp, kBack, kLeft, kFront, kRight, kDown };
/// How many faces a cube map has.
inline constexpr std::size_t kCubeFaces = 6;
/// The k-th face in that order, and back. \pre k < kCubeFaces
constexpr CubeFace cube_face(std::size_t k) { return static_cast<CubeFace>(k); }
constexpr std::size_t index(CubeFace face) { return static_cast<std::size_t>(face); }

/// Axes of a face in the panorama frame. The point (s, t) in [0, 1]^2 of the face lies in the
/// direction forward + (2 s - 1) right + (2 t - 1) down. It counts s from the left edge, t from the
/// top.
struct FaceAxes {
  Vec3d right, down, forward;
};
/// Axes of each face, by index(CubeFace).
inline constexpr std::array<FaceAxes, kCubeFaces> kFaceAxes{{
    {{-1, 0, 0}, {0, 0, -1}, {0, -1, 0}},  // up
    {{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}},   // back
    {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}},    // left
    {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},     // front
    {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}},    // right
    {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},    // down
}};

/// A point of a cube map.
struct FacePoint {
  CubeFace face = CubeFace::kFront;
  double s = 0, t = 0;  ///< [0, 1], from the left and the top edge
};

/// Direction of a point of a face, in the panorama frame. Not of unit length: its component along
/// the face's forward axis is 1. (s, t) outside [0, 1] continues the plane of the face.
Vec3d cube_direction(CubeFace face, double s, double t);
/// The face that a direction of the panorama frame hits. On an edge between faces: the one whose
/// axis comes first in y, x, z. \pre direction is not (0, 0, 0)
inline CubeFace face_towards(Vec3d direction) {
  const double x = std::abs(direction.x), y = std::abs(direction.y), z = std::abs(direction.z);
  if (y >= x && y >= z) return direction.y < 0 ? CubeFace::kUp : CubeFace::kDown;
  if (x >= z) return direction.x < 0 ? CubeFace::kLeft : CubeFace::kRight;
  return direction.z < 0 ? CubeFace::kBack : CubeFace::kFront;
}
/// face_towards(), and the point of the face. \pre direction is not (0, 0, 0)
FacePoint project_to_cube(Vec3d direction);

/// Camera frame -> world: the columns are the camera's right, down and forward.
Mat3d world_from_camera(Radians heading, Radians elevation);

/// Rays through the centres of a picture's pixels, in some frame. The ray of row i (0 is the top
/// row) and column j is origin + i * row + j * column. Not of unit length: its component along the
/// optical axis is 1.
struct PixelRays {
  Vec3d origin, row, column;
  /// Direction through the point in row i and column j of the picture; not normalised.
  Vec3d at(double i, double j) const { return origin + i * row + j * column; }
};
/// Rays of a camera, in the frame that the rotation maps to. \pre camera is valid
PixelRays pixel_rays(const Camera& camera, const Mat3d& frame_from_camera);

/// Faces that a picture may show parts of, as bits 1 << index(face): all that it shows, and perhaps
/// more.
std::uint8_t faces_in_view(const Camera& camera, const Mat3d& panorama_from_camera);

}  // namespace enfilade
