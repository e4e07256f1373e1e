/// \file  Pose traces: how the camera of an annotator of RxR moved while a path was described
/// (guides) or followed (followers).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::tasks {

/// Position and direction of a camera, in our world frame.
struct CameraLook {
  Vec3d position;      ///< metres
  Radians heading;     ///< [0, 2 pi)
  Radians elevation;   ///< from the horizon, up positive
  Radians view_angle;  ///< from the lower edge of the picture to the upper one
  double aspect = 1;   ///< width / height of the picture
};

/// A moment of a trace.
struct PoseSnapshot {
  std::string viewpoint;             ///< `pano`
  double time = 0;                   ///< seconds from the beginning
  std::optional<double> audio_time;  ///< followers: played part of the guide's audio, seconds.
  /// Row-major 4 x 4 matrices as the data set's own viewer takes them. `extrinsic` goes from the
  /// camera's frame (x right, y up, looking along -z) to a world whose y is up. Ours is (x, -z, y)
  /// of it, metres. `intrinsic` is OpenGL's projection matrix.
  std::array<float, 16> extrinsic{}, intrinsic{};

  friend bool operator==(const PoseSnapshot&, const PoseSnapshot&) = default;
};

/// Rows of a viewpoint's picture in `image_mask`, an equirectangular panorama whose middle column
/// has heading 0.
inline constexpr std::size_t kMaskHeight = 128;
/// Columns of that picture.
inline constexpr std::size_t kMaskWidth = 256;
/// Views in `feature_weights`: MatterSim's 36.
inline constexpr std::size_t kMaskViews = 36;

/// A trace. Fields per viewpoint of the path are in its order; each may be left out.
struct PoseTrace {
  std::vector<PoseSnapshot> snapshots;  ///< in the order of time
  std::size_t viewpoints = 0;           ///< of the path; 0 if none of the following is there
  /// Which pixels were seen: viewpoints x kMaskHeight x kMaskWidth of 0 or 1, or empty.
  std::vector<std::uint8_t> image_mask;
  /// How much of each view was seen: viewpoints x kMaskViews, or empty.
  std::vector<float> feature_weights;
  /// Which of the `subwords` were said there: viewpoints x subwords of 0 or 1, or empty.
  std::vector<std::uint8_t> text_mask;
  std::size_t subwords = 0;

  friend bool operator==(const PoseTrace&, const PoseTrace&) = default;
};

/// Whose trace.
enum class TraceRole : std::uint8_t { kGuide, kFollower };

/// "000026_guide_pose_trace.npz". \param id  the instruction's of a guide, the demonstration's of a
/// follower
std::string pose_trace_name(TraceRole role, std::int64_t id);

/// Reads a `.npz`, with stored or deflated arrays. Vectors may have the shape (n,) or (n, 1),
/// matrices (n, 16) or (n, 4, 4); `text_masks` is `text_mask`, too. A time of the first snapshot
/// that is not a number is 0, as in the data set's viewer. Arrays of other names are ignored.
/// \throws FileError
/// \throws InvalidInput listing its faults with places such as `$.pano[3]`:
/// - not a zip file, or a damaged one
/// - no `pano`, `time`, `extrinsic_matrix` or `intrinsic_matrix`
/// - arrays of more than 256 MiB or 1,048,576 snapshots, of other types or shapes, or whose lengths
///   differ
/// - a bad id, an infinite or NaN number, one beyond 1e6 in a matrix or beyond a float in a weight
/// - decreasing time
PoseTrace load_pose_trace(const std::filesystem::path& file);
/// The same of a file in memory. \param name  for messages
PoseTrace parse_pose_trace(std::string bytes, const std::string& name);

/// A `.npz` that parse_pose_trace() reads back equal, except that times are rounded to float. It
/// has the shapes and types of the released files.
/// \throws ArgumentError for no snapshot, or arrays of other sizes than the struct's
/// \throws ArgumentError for an audio time in some snapshots only
/// \throws ArgumentError for content that parse_pose_trace() refuses, and text that is not UTF-8
std::string to_npz(const PoseTrace& trace);

/// Position and direction of a snapshot's camera. A matrix that is not a rigid motion gives the
/// direction of its viewing axis; one without any gives heading and elevation 0.
CameraLook look_of(const PoseSnapshot& snapshot);
/// A snapshot of a level camera. Near and far planes of the projection are at 0.1 and 1000 m.
/// \pre 0 < look.view_angle < pi, look.aspect > 0
PoseSnapshot snapshot_of(std::string viewpoint, double time, const CameraLook& look);

}  // namespace enfilade::tasks
