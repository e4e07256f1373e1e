#include "enfilade/scan/matterport_names.h"

#include <fmt/format.h>

namespace enfilade::scan {

std::string skybox_strip_name(std::string_view viewpoint, Layer layer) {
  switch (layer) {
    case Layer::kColour:
      return fmt::format("{}_skybox_small.jpg", viewpoint);
    case Layer::kDepth:
      return fmt::format("{}_skybox_depth_small.png", viewpoint);
    case Layer::kClass:
      return fmt::format("{}_skybox_class_small.png", viewpoint);
    case Layer::kInstance:
      break;
  }
  return fmt::format("{}_skybox_instance_small.png", viewpoint);
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
