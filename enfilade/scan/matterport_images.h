/// \file  Panoramas in the files of Matterport3D's download and of Matterport3DSimulator.
#pragma once
#include <filesystem>
#include <memory>
#include <string>

#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan {

/// Reads a scan's panoramas from folders or from the `.zip` files of the download, unextracted.
///
/// For a scan S below a root folder R, these are tried as folders, then as files with `.zip` added:
/// `R/S/<kind>`, `R/v1/scans/S/<kind>`, `R/scans/S/<kind>`, `R/<kind>`.
///
/// Kinds and files:
/// - matterport_skybox_images
///   - `<viewpoint>_skybox_small.jpg` (strip of 6, RGB)
///   - `<viewpoint>_skybox<0..5>_sami.jpg` (one face each)
///   - `<viewpoint>_skybox_depth_small.png` (strip, 16 bit grey, as Layer::kDepth)
///   - `<viewpoint>_skybox_class_small.png` (strip, 8 or 16 bit grey)
///   - `<viewpoint>_skybox_instance_small.png` (strip, 16 bit grey, or 8-bit RGBA: id = R + 256 G +
///     65536 B + 2^24 A)
/// - undistorted_camera_parameters: `<scan>.conf`, and undistorted_depth_images:
///   `<viewpoint>_d<cam>_<yaw>.png`; depth without a strip, built by depth_skybox.h
///
/// A file is read from the first place that has it. Strips are preferred to faces, as
/// Matterport3DSimulator renders strips. The names of class and instance strips are Enfilade's own:
/// Matterport3D has no semantic pictures. Depth from undistorted images has the size of the colour
/// faces. It takes seconds for each panorama, in the calling thread; pack() such scans first.
class MatterportImages final : public PanoramaSource {
 public:
  /// \param root as above  \param connectivity folder of `<scan>_connectivity.json`
  /// \throws LookupError if no folder or zip of sky-boxes is found, naming all that were tried;
  /// FileError, InvalidInput for a broken zip or connectivity file
  static std::shared_ptr<const MatterportImages> open(const std::filesystem::path& root,
                                                      const std::filesystem::path& connectivity,
                                                      const std::string& scan);
  ~MatterportImages() override;

  Connectivity connectivity() const override;
  FaceSizes face_sizes(ViewpointIndex viewpoint) const override;
  bool reads_whole_panoramas() const noexcept override { return true; }
  /// The JPEG files of faces unchanged, or a strip's, cut between its blocks
  /// (image::cut_jpeg_strip). No value if that cannot be done.
  /// \throws as read_colour()
  std::optional<std::array<std::string, kCubeFaces>> colour_jpegs(
      ViewpointIndex viewpoint) const override;
  std::string state() const override;  ///< names, sizes and times of all files
  std::string tried(Layer layer, ViewpointIndex viewpoint) const override;

 private:
  struct Impl;
  void read(Layer layer, ViewpointIndex viewpoint, FaceMask wanted,
            const FaceBuffers& buffers) const override;
  template <class Read>
  auto with_context(ViewpointIndex viewpoint, const Read& read) const;
  FaceSizes sizes_at(ViewpointIndex viewpoint) const;
  template <class T>
  image::CubeMap<T> checked(Layer layer, ViewpointIndex viewpoint,
                            std::optional<image::CubeMap<T>> map) const;
  explicit MatterportImages(std::unique_ptr<Impl> impl, std::string origin,
                            std::vector<PanoramaPose> poses, std::string scan);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::scan
