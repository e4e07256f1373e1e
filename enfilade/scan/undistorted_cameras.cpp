#include "enfilade/scan/undistorted_cameras.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"

namespace enfilade::scan {
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

/// A value for a message: escaped, and shortened to less than a line.
std::string shown(std::string_view value) {
  constexpr std::size_t kLongest = 40;
  if (value.size() <= kLongest) return fmt::format("{:?}", value);
  return fmt::format("{:?}...", value.substr(0, kLongest));
}

/// A file with this many faults is of another kind; more would only take memory.
constexpr std::size_t kMostFaults = 100;

class Parser {
 public:
  explicit Parser(const std::string& file) : file_(file) {}

  UndistortedCameras parse(std::string_view text) {
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
          fmt::format("{} has {} fields, not {}", shown(words[0]), words.size() - 1, fields));
    return false;
  }

  void read_line(const Words& words) {
    if (words.empty() || words[0].starts_with('#')) return;
    const std::string_view command = words[0];
    if (command == "dataset") {
      if (has_fields(words, 1) && words[1] != "matterport") {
        fault("bad-dataset", fmt::format("dataset {}, not \"matterport\"", shown(words[1])));
      }
    } else if (command == "n_images") {
      read_count(words);
    } else if (command == "depth_directory") {
      if (has_fields(words, 1)) result_.depth_directory = words[1];
    } else if (command == "color_directory") {
      if (has_fields(words, 1)) result_.colour_directory = words[1];
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
                        shown(command)));
    }
  }

  void read_count(const Words& words) {
    if (!has_fields(words, 1)) return;
    expected_ = parse_number<std::uint64_t>(words[1]);
    if (!expected_) {
      fault("bad-number",
            fmt::format("n_images {}, not a whole number from 0 on", shown(words[1])));
    }
  }

  bool read_numbers(const Words& words, std::size_t first, std::span<double> values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto value = parse_number<double>(words[first + i]);
      if (!value || !std::isfinite(*value)) {
        fault("bad-number",
              fmt::format("field {}: {}, not a number", first + i, shown(words[first + i])));
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
      fault("bad-name", fmt::format("{}, not <viewpoint>_d<cam>_<yaw>.png", shown(words[1])));
      return;
    }
    camera.fx = intrinsics_[0], camera.fy = intrinsics_[1];
    camera.cx = intrinsics_[2], camera.cy = intrinsics_[3];
    camera.world_from_camera = rotation_of(p);
    camera.position = {p[3], p[7], p[11]};
    if (!is_rotation(camera.world_from_camera) || p[12] != 0 || p[13] != 0 || p[14] != 0 ||
        p[15] != 1) {
      fault("bad-pose", fmt::format("the pose of {} is no rotation and place, row by row: 12 "
                                    "numbers, then 0 0 0 1",
                                    shown(words[1])));
      return;
    }
    result_.cameras.push_back(std::move(camera));
  }

  enum class Intrinsics { kNone, kGiven, kInFile, kBroken };

  const std::string& file_;
  std::size_t line_ = 0;
  UndistortedCameras result_;
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

UndistortedCameras parse_undistorted_cameras(std::string_view text, const std::string& file) {
  return Parser(file).parse(text);
}

}  // namespace enfilade::scan
