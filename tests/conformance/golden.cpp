#include "tests/conformance/golden.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/detail/json.h"
#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"

namespace enfilade::tests {
namespace {

using json::Element;
using json::Faults;
using json::Path;

std::string read_text(Element element, const Path& path, Faults& faults) {
  return std::string(json::string(element, path, faults).value_or(""));
}

double read_number(Element element, const Path& path, Faults& faults) {
  return json::number(element, path, faults).value_or(0);
}

std::uint32_t read_pixels(Element element, const Path& path, Faults& faults) {
  const std::int64_t value = json::integer(element, path, faults).value_or(1);
  if (value > 0 && value <= 16384) return static_cast<std::uint32_t>(value);
  faults.error(path, "bad-size", fmt::format("{} pixels; 1 to 16384 are allowed", value));
  return 1;
}

// A picture's name must not lead out of the folder.
std::string read_file_name(Element element, const Path& path, Faults& faults) {
  std::string name = read_text(element, path, faults);
  if (name.find_first_of("/\\") != std::string::npos || name.starts_with(".")) {
    faults.error(path, "bad-name",
                 fmt::format("{:?} is not the name of a file beside this one", name));
  }
  return name;
}

GoldenPose read_pose(Element element, const Path& path, Faults& faults) {
  GoldenPose pose;
  constexpr std::array<json::Field, 9> kFields{{{"rgb"},
                                                {"depth"},
                                                {"scanId"},
                                                {"viewpointId"},
                                                {"width"},
                                                {"height"},
                                                {"vfov"},
                                                {"heading"},
                                                {"elevation"}}};
  std::array<std::optional<Element>, kFields.size()> f;
  if (!json::fields(element, kFields, f, path, faults)) return pose;
  pose.rgb = read_file_name(*f[0], Path(path, "rgb"), faults);
  pose.depth = read_file_name(*f[1], Path(path, "depth"), faults);
  pose.scan = read_text(*f[2], Path(path, "scanId"), faults);
  pose.viewpoint = read_text(*f[3], Path(path, "viewpointId"), faults);
  pose.camera = {read_pixels(*f[4], Path(path, "width"), faults),
                 read_pixels(*f[5], Path(path, "height"), faults),
                 Radians(read_number(*f[6], Path(path, "vfov"), faults))};
  pose.heading = Radians(read_number(*f[7], Path(path, "heading"), faults));
  pose.elevation = Radians(read_number(*f[8], Path(path, "elevation"), faults));
  try {
    validate(pose.camera);
  } catch (const ArgumentError& error) {
    faults.error(path, "bad-camera", error.what());
  }
  return pose;
}

std::vector<GoldenPose> read_poses(const json::Document& document) {
  Faults faults(document.name());
  const Path root;
  const Path list(root, "items");
  std::array<std::optional<Element>, 1> top;
  constexpr std::array<json::Field, 1> kTop{{{"items"}}};
  std::vector<GoldenPose> poses;
  if (json::fields(document.root(), kTop, top, root, faults)) {
    if (const auto items = json::array(*top[0], list, faults)) {
      for (const Element item : *items) {
        poses.push_back(read_pose(item, Path(list, poses.size()), faults));
      }
      if (poses.empty()) faults.error(list, "no-items", "no picture to compare");
    }
  }
  faults.throw_if_errors();
  return poses;
}

void expect_size(std::uint32_t width, std::uint32_t height, const GoldenPose& pose,
                 const std::filesystem::path& file) {
  if (width == pose.camera.width && height == pose.camera.height) return;
  throw InvalidInput({{Severity::kError, file.string(), "", "bad-size",
                       fmt::format("{} x {} pixels; golden.json says {} x {}", width, height,
                                   pose.camera.width, pose.camera.height)}});
}

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

// Quarter millimetres as grey, 8 m and more white.
std::uint8_t grey(int units) { return static_cast<std::uint8_t>(std::min(units / 126, 255)); }

}  // namespace

std::vector<GoldenPose> load_golden(const std::filesystem::path& folder) {
  return read_poses(json::Document::load(folder / "golden.json"));
}

std::vector<GoldenPose> parse_golden(std::string_view text, const std::string& name) {
  return read_poses(json::Document::parse(text, name));
}

double ColourDifference::mean() const {
  return pixels == 0 ? 0 : static_cast<double>(sum) / (3.0 * static_cast<double>(pixels));
}

double ColourDifference::share(std::size_t some) const { return ratio(some, pixels); }

ColourDifference& ColourDifference::operator+=(const ColourDifference& other) {
  pixels += other.pixels;
  sum += other.sum;
  largest = std::max(largest, other.largest);
  above_1 += other.above_1;
  above_2 += other.above_2;
  above_8 += other.above_8;
  return *this;
}

double DepthDifference::share() const { return ratio(identical, pixels); }

DepthDifference& DepthDifference::operator+=(const DepthDifference& other) {
  pixels += other.pixels;
  identical += other.identical;
  largest = std::max(largest, other.largest);
  return *this;
}

ColourDifference compare(const image::Image8& ours, const image::Image8& golden) {
  EN_CHECK_EQ(ours.pixels.size(), golden.pixels.size());
  ColourDifference found;
  found.pixels = ours.pixels.size() / 3;
  for (std::size_t i = 0; i < ours.pixels.size(); i += 3) {
    int largest = 0;
    for (std::size_t c = i; c < i + 3; ++c) {
      const int difference = std::abs(ours.pixels[c] - golden.pixels[c]);
      found.sum += static_cast<std::uint64_t>(difference);
      largest = std::max(largest, difference);
    }
    found.largest = std::max(found.largest, largest);
    if (largest > 1) ++found.above_1;
    if (largest > 2) ++found.above_2;
    if (largest > 8) ++found.above_8;
  }
  return found;
}

DepthDifference compare(const image::Image16& ours, const image::Image16& golden) {
  EN_CHECK_EQ(ours.pixels.size(), golden.pixels.size());
  DepthDifference found;
  found.pixels = ours.pixels.size();
  for (std::size_t i = 0; i < ours.pixels.size(); ++i) {
    const int difference = std::abs(ours.pixels[i] - golden.pixels[i]);
    if (difference == 0) ++found.identical;
    found.largest = std::max(found.largest, difference);
  }
  return found;
}

bool within(const GoldenTolerances& t, const ColourDifference& colour,
            const DepthDifference& depth) {
  const std::size_t usual = colour.pixels - colour.above_2;
  return colour.mean() <= t.mean && colour.share(usual) >= t.usual_share &&
         colour.largest <= t.most && depth.share() >= t.identical_share;
}

GoldenPicture render_golden(render::Renderer& renderer, const scan::PanoramaSet& panoramas,
                            const GoldenPose& pose) {
  const ScanIndex scan = panoramas.at(pose.scan);
  const render::View view{scan, panoramas.source(scan).at(pose.viewpoint), pose.heading,
                          pose.elevation};
  GoldenPicture picture{{pose.camera.width, pose.camera.height, 3},
                        {pose.camera.width, pose.camera.height, 1}};
  render::Outputs outputs;
  outputs.colour.emplace();
  outputs.colour->pixels = std::as_writable_bytes(std::span(picture.colour.pixels));
  outputs.depth.emplace();
  outputs.depth->format = render::DepthFormat::kQuarterMillimetresUint16;
  outputs.depth->pixels = std::as_writable_bytes(std::span(picture.depth.pixels));
  renderer.render(pose.camera, std::span(&view, 1), outputs);
  return picture;
}

GoldenPicture load_pictures(const std::filesystem::path& folder, const GoldenPose& pose) {
  const auto rgb = folder / pose.rgb, depth = folder / pose.depth;
  GoldenPicture picture{image::decode_png8(image::bytes_of(read_file(rgb)), rgb.string()),
                        image::decode_png16(image::bytes_of(read_file(depth)), depth.string())};
  expect_size(picture.colour.width, picture.colour.height, pose, rgb);
  expect_size(picture.depth.width, picture.depth.height, pose, depth);
  if (picture.colour.channels != 3) {
    throw InvalidInput({{Severity::kError, rgb.string(), "", "bad-channels",
                         fmt::format("{} channels; 3 are expected", picture.colour.channels)}});
  }
  return picture;
}

image::Image8 side_by_side(const image::Image8& ours, const image::Image8& golden) {
  image::Image8 sheet(3 * ours.width, ours.height, 3);
  for (std::size_t y = 0; y < ours.height; ++y) {
    for (std::size_t i = 0; i < std::size_t{ours.width} * 3; ++i) {
      const int a = ours.at(0, y)[i], b = golden.at(0, y)[i];
      sheet.at(0, y)[i] = ours.at(0, y)[i];
      sheet.at(ours.width, y)[i] = golden.at(0, y)[i];
      sheet.at(std::size_t{2} * ours.width, y)[i] =
          static_cast<std::uint8_t>(std::min(32 * std::abs(a - b), 255));
    }
  }
  return sheet;
}

image::Image8 side_by_side(const image::Image16& ours, const image::Image16& golden) {
  image::Image8 sheet(3 * ours.width, ours.height, 1);
  for (std::size_t y = 0; y < ours.height; ++y) {
    for (std::size_t x = 0; x < ours.width; ++x) {
      const int a = *ours.at(x, y), b = *golden.at(x, y);
      *sheet.at(x, y) = grey(a);
      *sheet.at(ours.width + x, y) = grey(b);
      *sheet.at(std::size_t{2} * ours.width + x, y) =
          a == b ? std::uint8_t{0}
                 : static_cast<std::uint8_t>(std::max<int>(grey(std::abs(a - b)), 64));
    }
  }
  return sheet;
}

}  // namespace enfilade::tests
