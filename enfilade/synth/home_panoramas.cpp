#include "enfilade/synth/home_panoramas.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::synth {
namespace {

// The last panorama that a thread has taken.
struct Taken {
  std::uint64_t serial = 0;
  ViewpointIndex viewpoint;
  mesh::CubeCapture pictures;
};

std::uint64_t next_serial() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

template <class T>
void copy(const image::CubeMap<T>& faces, scan::FaceMask wanted,
          const std::array<T*, kCubeFaces>& buffers) {
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    if ((wanted >> k & 1U) != 0) std::ranges::copy(faces[k].pixels, buffers[k]);
  }
}

}  // namespace

MeshPanoramas::MeshPanoramas(std::shared_ptr<const mesh::LitMesh> mesh,
                             scan::Connectivity connectivity, std::uint32_t face_size,
                             const mesh::CaptureOptions& capture, std::string state)
    : PanoramaSource(connectivity.scan, "<synthetic " + connectivity.scan + ">",
                     scan::poses_of(connectivity)),
      mesh_(std::move(mesh)),
      connectivity_(std::move(connectivity)),
      face_size_(face_size),
      options_(capture),
      state_(std::move(state)),
      serial_(next_serial()) {
  if (face_size == 0) throw ArgumentError("face_size: 0, but a face has at least one texel");
  options_.threads = 1;
  options_.colour = options_.depth = options_.labels = true;
}

scan::FaceSizes MeshPanoramas::face_sizes(ViewpointIndex) const {
  return {face_size_, face_size_, face_size_, face_size_};
}

const mesh::CubeCapture& MeshPanoramas::capture(ViewpointIndex viewpoint) const {
  static thread_local Taken taken;
  if (taken.serial != serial_ || taken.viewpoint != viewpoint) {
    const scan::PanoramaPose& pose = poses()[viewpoint.at()];
    taken.serial = 0;  // in case it throws
    taken.pictures =
        capture_cube(*mesh_, pose.world_from_panorama, pose.position, face_size_, options_);
    taken.serial = serial_;
    taken.viewpoint = viewpoint;
  }
  return taken.pictures;
}

void MeshPanoramas::read_colour(ViewpointIndex viewpoint, scan::FaceMask wanted,
                                const std::array<image::BorderedFace, kCubeFaces>& buffers) const {
  const mesh::CubeCapture& pictures = capture(viewpoint);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    if ((wanted >> k & 1U) == 0) continue;
    write_face(buffers[k], pictures.colour[k]);
    write_border(buffers[k], image::border_of(pictures.colour, cube_face(k)));
  }
}

void MeshPanoramas::read_16(scan::Layer layer, ViewpointIndex viewpoint, scan::FaceMask wanted,
                            const std::array<std::uint16_t*, kCubeFaces>& buffers) const {
  const mesh::CubeCapture& pictures = capture(viewpoint);
  copy(layer == scan::Layer::kDepth ? pictures.depth : pictures.classes, wanted, buffers);
}

void MeshPanoramas::read_instances(ViewpointIndex viewpoint, scan::FaceMask wanted,
                                   const std::array<std::uint32_t*, kCubeFaces>& buffers) const {
  copy(capture(viewpoint).instances, wanted, buffers);
}

}  // namespace enfilade::synth
