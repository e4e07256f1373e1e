#include "enfilade/scan/matterport_names.h"

#include <fmt/format.h>
#include <array>

namespace enfilade::scan {

std::string skybox_strip_name(std::string_view viewpoint, Layer layer) {
  constexpr std::array<std::string_view, kLayers> kEndings{"small.jpg", "depth_small.png",
                                                           "class_small.png", "instance_small.png"};
  return fmt::format("{}_skybox_{}", viewpoint, kEndings.at(index(layer)));
}

std::string skybox_face_name(std::string_view viewpoint, std::size_t face) {
  return fmt::format("{}_skybox{}_sami.jpg", viewpoint, face);
}

std::string colour_image_name(std::string_view viewpoint, std::size_t camera, std::size_t yaw) {
  return fmt::format("{}_i{}_{}.jpg", viewpoint, camera, yaw);
}

std::string depth_image_name(std::string_view viewpoint, std::size_t camera, std::size_t yaw) {
  return fmt::format("{}_d{}_{}.png", viewpoint, camera, yaw);
}

std::string camera_pose_name(std::string_view viewpoint, std::size_t camera, std::size_t yaw) {
  return fmt::format("{}_pose_{}_{}.txt", viewpoint, camera, yaw);
}

std::string camera_intrinsics_name(std::string_view viewpoint, std::size_t camera) {
  return fmt::format("{}_intrinsics_{}.txt", viewpoint, camera);
}

}  // namespace enfilade::scan
