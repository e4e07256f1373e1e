#include "enfilade/capture/mesh_panoramas.h"

#include <atomic>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::capture {
namespace {

// The last panorama that a thread has rendered.
struct Taken {
  std::uint64_t serial = 0;
  ViewpointIndex viewpoint;
  scan::Panorama pictures;
};

std::uint64_t next_serial() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
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

const scan::Panorama& MeshPanoramas::capture(ViewpointIndex viewpoint) const {
  static thread_local Taken taken;
  if (taken.serial != serial_ || taken.viewpoint != viewpoint) {
    const scan::PanoramaPose& pose = poses()[viewpoint.at()];
    taken.serial = 0;  // in case it throws
    mesh::CubeCapture cube =
        capture_cube(*mesh_, pose.world_from_panorama, pose.position, face_size_, options_);
    taken.pictures = {std::move(cube.colour), std::move(cube.depth), std::move(cube.classes),
                      std::move(cube.instances)};
    taken.serial = serial_;
    taken.viewpoint = viewpoint;
  }
  return taken.pictures;
}

void MeshPanoramas::read(scan::Layer layer, ViewpointIndex viewpoint, scan::FaceMask wanted,
                         const scan::FaceBuffers& buffers) const {
  capture(viewpoint).copy_to(layer, wanted, buffers);
}

}  // namespace enfilade::capture
