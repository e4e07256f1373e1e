#include "bench/peer/remap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "enfilade/geometry/cube_map.h"

namespace enfilade::bench {
namespace {

struct Direction {
  double heading, elevation;  // degrees
};
constexpr std::array<Direction, kCubeFaces> kFaces{
    {{0, 0}, {90, 0}, {180, 0}, {270, 0}, {0, 90}, {0, -90}}};

// The point of a direction of the world, in a picture of all faces one below the other.
cv::Point2d point_of(Vec3d direction, double face_size) {
  for (std::size_t k = 0; k < kFaces.size(); ++k) {
    const Vec3d p =
        transpose(world_from_camera(degrees(kFaces[k].heading), degrees(kFaces[k].elevation))) *
        direction;
    constexpr double kBeyond = 1 + 1e-9;  // rounding must leave no direction without a face
    if (p.z <= 0 || std::abs(p.x) > kBeyond * p.z || std::abs(p.y) > kBeyond * p.z) continue;
    const auto texel = [&](double t) {  // stays in its face: its neighbours here are not those
      return std::clamp((t / p.z + 1) / 2 * face_size - 0.5, 0.0, face_size - 1);
    };
    return {texel(p.x), texel(p.y) + static_cast<double>(k) * face_size};
  }
  return {};
}

struct Map {
  cv::Mat whole, parts;  // CV_16SC2, and the fractions in a table's numbers
};

Map map_of(const Camera& camera, const render::View& view, std::uint32_t face_size) {
  const PixelRays rays = pixel_rays(camera, world_from_camera(view.heading, view.elevation));
  const int rows = static_cast<int>(camera.height), columns = static_cast<int>(camera.width);
  cv::Mat points(rows, columns, CV_32FC2);
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      points.at<cv::Point2f>(i, j) = point_of(rays.at(i, j), face_size);
    }
  }
  Map map;
  cv::convertMaps(points, cv::noArray(), map.whole, map.parts, CV_16SC2);
  return map;
}

class OpenCvRemap final : public Remap {
 public:
  OpenCvRemap(const Camera& camera, std::uint32_t face_size)
      : camera_(camera), face_size_(static_cast<int>(face_size)) {
    cv::setNumThreads(1);
    for (const render::View& view : render::discrete_views(ScanIndex(), ViewpointIndex())) {
      maps_.push_back(map_of(camera, view, face_size));
    }
  }

  std::size_t add(std::vector<std::uint8_t> faces) override {
    panoramas_.push_back(std::move(faces));
    return panoramas_.size() - 1;
  }

  void draw(std::size_t panorama, std::size_t view, std::span<std::uint8_t> rgb) override {
    constexpr int kFaceCount = static_cast<int>(kFaces.size());
    const cv::Mat from(kFaceCount * face_size_, face_size_, CV_8UC3, panoramas_[panorama].data());
    cv::Mat to(static_cast<int>(camera_.height), static_cast<int>(camera_.width), CV_8UC3,
               rgb.data());
    cv::remap(from, to, maps_[view].whole, maps_[view].parts, cv::INTER_LINEAR,
              cv::BORDER_REPLICATE);
  }

 private:
  Camera camera_;
  int face_size_;
  std::vector<Map> maps_;
  std::vector<std::vector<std::uint8_t>> panoramas_;
};

}  // namespace

std::vector<render::View> face_views(ScanIndex scan, ViewpointIndex viewpoint) {
  std::vector<render::View> views;
  for (const Direction& face : kFaces) {
    views.push_back({scan, viewpoint, degrees(face.heading), degrees(face.elevation)});
  }
  return views;
}

std::unique_ptr<Remap> make_remap(const Camera& camera, std::uint32_t face_size) {
  return std::make_unique<OpenCvRemap>(camera, face_size);
}

std::string remap_description() { return "OpenCV " + cv::getVersionString(); }

bool remap_built() { return true; }

}  // namespace enfilade::bench
