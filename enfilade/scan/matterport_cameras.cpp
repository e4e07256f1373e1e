#include "enfilade/scan/matterport_cameras.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/scan/matterport_images.h"

namespace enfilade::scan {
namespace {

/// One of the three cameras, for pictures of kKindWidth.
struct RigCameraKind {
  double elevation;       ///< degrees above the horizon
  Vec3d beside;           ///< of the eye, metres: to the right, down, ahead of the turned rig
  double fx, fy, cx, cy;  ///< pixels
};
constexpr double kKindWidth = 1280;
/// Invented values, close to those of calibrated rigs: all cameras differ, and no principal point
/// is in the middle (639.5, 511.5). In Matterport3D's files, the camera of the first picture is at
/// most 3.5 cm from the eye.
constexpr std::array<RigCameraKind, kRigCameras> kKinds{{
    {41, {.010, -.020, .025}, 1076.45, 1077.19, 629.48, 505.46},
    {0, {.010, 0, .027}, 1074.28, 1075.36, 640.21, 517.02},
    {-42, {.011, .018, .025}, 1077.93, 1078.41, 646.87, 499.87},
}};

/// Rotated to the right about the panorama's vertical axis, then up about the camera's x axis.
Mat3d panorama_from_camera(double heading, double elevation) {
  const double sh = std::sin(heading), ch = std::cos(heading);
  const double se = std::sin(elevation), ce = std::cos(elevation);
  // Columns: right, down, ahead. Down is +y of the panorama.
  return {{ch, se * sh, ce * sh, 0, ce, -se, -sh, se * ch, ce * ch}};
}

/// Rotation matrices of common angles contain values such as 6e-17 instead of 0.
double rounded(double value) { return std::round(value * 1e10) / 1e10 + 0.; }

std::string row(const Mat3d& m, std::size_t i, double place) {
  return fmt::format("{} {} {} {}", rounded(m.m[3 * i]), rounded(m.m[3 * i + 1]),
                     rounded(m.m[3 * i + 2]), rounded(place));
}

std::string rows_of(const Mat3d& m, Vec3d position, const char* between) {
  return row(m, 0, position.x) + between + row(m, 1, position.y) + between + row(m, 2, position.z) +
         between + "0 0 0 1";
}

}  // namespace

std::array<RigCamera, kRigImages> rig_cameras(const PanoramaPose& eye, std::uint32_t width) {
  if (width < 10) throw ArgumentError(fmt::format("width: {}, not at least 10 pixels", width));
  constexpr double kDegree = std::numbers::pi / 180;
  const double scale = width / kKindWidth;
  std::array<RigCamera, kRigImages> cameras;
  for (std::size_t k = 0; k < kRigImages; ++k) {
    RigCamera& c = cameras[k];
    const RigCameraKind& kind = kKinds[k / kRigYaws];
    c.viewpoint = eye.viewpoint;
    c.camera = k / kRigYaws;
    c.yaw = k % kRigYaws;
    c.width = width;
    c.height = width * 4 / 5;
    c.fx = kind.fx * scale;
    c.fy = kind.fy * scale;
    // Scaled about the picture's edge, which is half a pixel outside the first pixels' centres.
    c.cx = (kind.cx + .5) * scale - .5;
    c.cy = (kind.cy + .5) * scale - .5;
    const double heading = 60 * (static_cast<double>(c.yaw) - 2) * kDegree;
    c.world_from_camera =
        eye.world_from_panorama * panorama_from_camera(heading, kind.elevation * kDegree);
    c.position =
        eye.position + eye.world_from_panorama * (panorama_from_camera(heading, 0) * kind.beside);
  }
  return cameras;
}

Mat3d with_y_up(const Mat3d& world_from_camera) {
  const auto& m = world_from_camera.m;
  return {{m[0], -m[1], -m[2], m[3], -m[4], -m[5], m[6], -m[7], -m[8]}};
}

std::string undistorted_cameras_text(std::span<const RigCamera> cameras) {
  std::string text = fmt::format(
      "dataset matterport\nn_images {}\ndepth_directory undistorted_depth_images\n"
      "color_directory undistorted_color_images\n",
      cameras.size());
  std::string last;
  for (const RigCamera& c : cameras) {
    const std::string intrinsics =
        fmt::format("\nintrinsics_matrix {} 0 {} 0 {} {} 0 0 1\n", rounded(c.fx), rounded(c.cx),
                    rounded(c.fy), rounded(c.height - 1 - c.cy));
    if (intrinsics != last) text += intrinsics;
    last = intrinsics;
    text += fmt::format("scan {} {} {}\n", depth_image_name(c.viewpoint, c.camera, c.yaw),
                        colour_image_name(c.viewpoint, c.camera, c.yaw),
                        rows_of(with_y_up(c.world_from_camera), c.position, " "));
  }
  return text;
}

std::string camera_pose_text(const RigCamera& camera) {
  return rows_of(camera.world_from_camera, camera.position, "\n") + "\n";
}

std::string camera_intrinsics_text(const RigCamera& camera) {
  return fmt::format("{} {} {} {} {} {} 0 0 0 0 0\n", camera.width, camera.height,
                     rounded(camera.fx), rounded(camera.fy), rounded(camera.cx),
                     rounded(camera.cy));
}

namespace {

using Words = std::vector<std::string_view>;

Words words_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r\v\f";
  Words words;
  for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

/// Name of a picture's file: a viewpoint's id, and `_d<cam>_<yaw>.png`.
constexpr std::size_t kLongestPicture = kLongestId + 16;
/// A file with this many faults is of another kind; more would only take memory.
constexpr std::size_t kMostFaults = 100;

class Parser {
 public:
  explicit Parser(const std::string& file) : file_(file) {}

  std::vector<UndistortedCamera> parse(std::string_view text) {
    for (std::size_t at = 0; at < text.size() && faults_.size() < kMostFaults;) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      ++line_;
      read_line(words_of(text.substr(at, end - at)));
      at = end + 1;
    }
    if (expected_ && *expected_ != scans_ && faults_.size() < kMostFaults) {
      ++line_;
      fault("wrong-count", fmt::format("the file ends after {} scan lines, not {} (n_images)",
                                       scans_, *expected_));
    }
    if (!faults_.empty()) throw InvalidInput(std::move(faults_));
    return std::move(result_);
  }

 private:
  void fault(const char* code, std::string message) {
    faults_.push_back(
        {Severity::kError, file_, fmt::format("line {}", line_), code, std::move(message)});
  }

  bool has_fields(const Words& words, std::size_t fields) {
    if (words.size() == fields + 1) return true;
    fault("wrong-length",
          fmt::format("{} has {} fields, not {}", quote(words[0]), words.size() - 1, fields));
    return false;
  }

  void read_line(const Words& words) {
    if (words.empty() || words[0].starts_with('#')) return;
    const std::string_view command = words[0];
    if (command == "dataset") {
      if (has_fields(words, 1) && words[1] != "matterport") {
        fault("bad-dataset", fmt::format("dataset {}, not \"matterport\"", quote(words[1])));
      }
    } else if (command == "n_images") {
      read_count(words);
    } else if (command == "depth_directory" || command == "color_directory") {
      has_fields(words, 1);
    } else if (command == "intrinsics_matrix") {
      read_intrinsics(words);
    } else if (command == "intrinsics") {
      // The file that it names is not in the download. The intrinsics read before do not hold for
      // the cameras that follow.
      state_ = Intrinsics::kInFile;
    } else if (command == "scan" || command == "image") {
      ++scans_;
      read_scan(words);
    } else if (command != "rectangle" && command != "mesh" && command != "texture_directory") {
      // Those three describe surfaces to be textured; pictures do not depend on them.
      fault("unknown-command",
            fmt::format("{} is no command; allowed: dataset, n_images, depth_directory, "
                        "color_directory, intrinsics_matrix, scan, image, and, without effect, "
                        "rectangle, mesh, texture_directory",
                        quote(command)));
    }
  }

  void read_count(const Words& words) {
    if (!has_fields(words, 1)) return;
    expected_ = parse_number<std::uint64_t>(words[1]);
    if (!expected_) {
      fault("bad-number",
            fmt::format("n_images {}, not a whole number from 0 on", quote(words[1])));
    }
  }

  bool read_numbers(const Words& words, std::size_t first, std::span<double> values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto value = parse_number<double>(words[first + i]);
      if (!value || !std::isfinite(*value)) {
        fault("bad-number",
              fmt::format("field {}: {}, not a number", first + i, quote(words[first + i])));
        return false;
      }
      values[i] = *value;
    }
    return true;
  }

  void read_intrinsics(const Words& words) {
    state_ = Intrinsics::kBroken;
    std::array<double, 9> k{};
    if (!has_fields(words, k.size()) || !read_numbers(words, 1, k)) return;
    if (!(k[0] > 0 && k[4] > 0)) {
      fault("bad-intrinsics", fmt::format("focal lengths {} and {}, not above 0", k[0], k[4]));
    } else if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
      fault("bad-intrinsics", "not of the form fx 0 cx 0 fy cy 0 0 1");
    } else {
      intrinsics_ = {k[0], k[4], k[2], k[5]};
      state_ = Intrinsics::kGiven;
    }
  }

  void read_scan(const Words& words) {
    std::array<double, 16> p{};
    if (!has_fields(words, 2 + p.size()) || !read_numbers(words, 3, p)) return;
    if (state_ == Intrinsics::kNone || state_ == Intrinsics::kInFile) {
      fault("no-intrinsics", state_ == Intrinsics::kNone
                                 ? "a camera before its intrinsics_matrix"
                                 : "a camera after `intrinsics <file>`, which is not read; an "
                                   "intrinsics_matrix is needed");
      return;
    }
    UndistortedCamera camera;
    camera.depth_file = words[1];
    camera.colour_file = words[2];
    if (camera.viewpoint().empty()) {
      fault("bad-name", fmt::format("{}, not <viewpoint>_d<cam>_<yaw>.png", quote(words[1])));
      return;
    }
    for (const auto& [id, most] : {std::pair(camera.viewpoint(), kLongestId),
                                   {words[1], kLongestPicture},
                                   {words[2], kLongestPicture}}) {
      if (std::string wrong = fault_of_id(id, most); !wrong.empty()) {
        fault("bad-id", std::move(wrong));
        return;
      }
    }
    camera.fx = intrinsics_[0], camera.fy = intrinsics_[1];
    camera.cx = intrinsics_[2], camera.cy = intrinsics_[3];
    camera.world_from_camera = rotation_of(p);
    camera.position = {p[3], p[7], p[11]};
    if (!is_rotation(camera.world_from_camera) || p[12] != 0 || p[13] != 0 || p[14] != 0 ||
        p[15] != 1) {
      fault("bad-pose", fmt::format("the pose of {} is no rotation and place, row by row: 12 "
                                    "numbers, then 0 0 0 1",
                                    quote(words[1])));
      return;
    }
    result_.push_back(std::move(camera));
  }

  enum class Intrinsics { kNone, kGiven, kInFile, kBroken };

  const std::string& file_;
  std::size_t line_ = 0;
  std::vector<UndistortedCamera> result_;
  std::vector<Diagnostic> faults_;
  std::optional<std::uint64_t> expected_;
  std::uint64_t scans_ = 0;
  Intrinsics state_ = Intrinsics::kNone;
  std::array<double, 4> intrinsics_{};
};

}  // namespace

std::string_view UndistortedCamera::viewpoint() const {
  const std::size_t end = depth_file.rfind("_d");
  return std::string_view(depth_file).substr(0, end == std::string::npos ? 0 : end);
}

std::vector<UndistortedCamera> parse_undistorted_cameras(std::string_view text,
                                                         const std::string& file) {
  return Parser(file).parse(text);
}

}  // namespace enfilade::scan
