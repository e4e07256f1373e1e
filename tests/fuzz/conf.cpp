// The reader of undistorted_camera_parameters/<scan>.conf, and what looks through its cameras.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/scan/depth_skybox.h"
#include "enfilade/scan/matterport_cameras.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const auto cameras = scan::parse_undistorted_cameras(text, "<fuzz>");
    std::vector<scan::DepthImage> images;
    for (const auto& camera : cameras) {
      EN_CHECK(!camera.viewpoint().empty());
      images.push_back({camera, image::Image16(8, 6, 1)});
      for (auto& depth : images.back().depth.pixels) depth = 4000;
      if (images.size() == 18) break;
    }
    const scan::PanoramaPose eye{"v", {}, {0, 0, 1.5}, true};
    scan::depth_skybox(images, eye, 8, 1);
  } catch (const Error&) {
  }
  return 0;
}
