/// \file  OpenCV's remap, which draws views of panoramas by maps that were made before.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/geometry/camera.h"
#include "enfilade/render/renderer.h"

namespace enfilade::bench {

/// The cameras whose pictures are the faces of a panorama in the world frame: level to the four
/// sides from heading 0 clockwise, then up, then down; of 90 degrees, square.
std::vector<render::View> face_views(ScanIndex scan, ViewpointIndex viewpoint);

/// Draws with one thread, linearly, by maps of 16-bit coordinates (CV_16SC2).
class Remap {
 public:
  virtual ~Remap() = default;
  /// Takes a panorama: pictures of face_views(), one after the other, RGB. Its number, from 0.
  virtual std::size_t add(std::vector<std::uint8_t> faces) = 0;
  /// Draws one of the 36 views of a panorama, RGB in rows. \pre both exist; rgb has its size
  virtual void draw(std::size_t panorama, std::size_t view, std::span<std::uint8_t> rgb) = 0;
};

/// Makes the maps of the 36 views. Null where this build has no OpenCV.
std::unique_ptr<Remap> make_remap(const Camera& camera, std::uint32_t face_size);

/// "OpenCV 4.6.0", or why this build has none.
std::string remap_description();
/// Whether this build has it.
bool remap_built();

}  // namespace enfilade::bench
