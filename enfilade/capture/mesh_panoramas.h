/// \file  Panoramas of a lit mesh, rendered on demand.
#pragma once
#include <memory>
#include <string>

#include "enfilade/mesh/capture.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::capture {

/// Panoramas of a lit mesh at the viewpoints of its graph, all four layers. Only each thread's last
/// panorama is kept, so that reading its layers one after another renders it once.
class MeshPanoramas final : public scan::PanoramaSource {
 public:
  /// \param state  text that changes with the pictures: PanoramaSource::state()
  /// \param capture its `threads` are ignored: a panorama is rendered on the caller's thread
  /// \throws ArgumentError for a face size of 0; InvalidInput as scan::poses_of()
  MeshPanoramas(std::shared_ptr<const mesh::LitMesh> mesh, scan::Connectivity connectivity,
                std::uint32_t face_size, const mesh::CaptureOptions& capture, std::string state);

  scan::Connectivity connectivity() const override { return connectivity_; }
  scan::FaceSizes face_sizes(ViewpointIndex viewpoint) const override;
  bool reads_whole_panoramas() const noexcept override { return true; }
  std::string state() const override { return state_; }

 private:
  void read(scan::Layer layer, ViewpointIndex viewpoint, scan::FaceMask wanted,
            const scan::FaceBuffers& buffers) const override;
  const scan::Panorama& capture(ViewpointIndex viewpoint) const;

  std::shared_ptr<const mesh::LitMesh> mesh_;
  scan::Connectivity connectivity_;
  std::uint32_t face_size_;
  mesh::CaptureOptions options_;
  std::string state_;
  std::uint64_t serial_;  // distinguishes this source from an earlier one at its address
};

}  // namespace enfilade::capture
