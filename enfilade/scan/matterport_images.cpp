#include "enfilade/scan/matterport_images.h"

#include <fmt/format.h>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/image/cube_border.h"
#include "enfilade/scan/detail/panorama_files.h"

namespace enfilade::scan {
namespace {

namespace fs = std::filesystem;
using detail::KindOfFiles;

/// The existing folders and zip files of one kind. \param tried gets all places that were looked at
KindOfFiles find_kind(const fs::path& root, const std::string& scan, const std::string& kind,
                      std::string& tried) {
  std::vector<std::shared_ptr<const FileTree>> trees;
  for (const fs::path& place : {root / scan / kind, root / "v1" / "scans" / scan / kind,
                                root / "scans" / scan / kind, root / kind}) {
    const std::string zip = place.string() + ".zip";
    std::error_code ignored;
    if (fs::is_directory(place, ignored)) trees.push_back(FileTree::folder(place));
    if (fs::is_regular_file(zip, ignored)) trees.push_back(FileTree::zip(zip));
    tried += fmt::format("\n  {}\n  {}", place.string(), zip);
  }
  return KindOfFiles(std::move(trees));
}

}  // namespace

struct MatterportImages::Impl {
  FaceSizes read_sizes(const std::string& viewpoint) const;
  std::optional<image::CubeMap<std::uint16_t>> read_depth(const PanoramaPose& pose) const;

  fs::path connectivity;  ///< folder
  detail::SkyboxFiles skybox;
  detail::UndistortedDepth undistorted;
  mutable std::mutex mutex{};
  /// The first result of face_sizes(), which callers allocate buffers by; files that change later
  /// must not change it.
  mutable std::vector<std::optional<FaceSizes>> sizes{};
};

MatterportImages::MatterportImages(std::unique_ptr<Impl> impl, std::string origin,
                                   std::vector<PanoramaPose> poses, std::string scan)
    : PanoramaSource(std::move(scan), std::move(origin), std::move(poses)), impl_(std::move(impl)) {
  impl_->sizes.resize(size());
}

MatterportImages::~MatterportImages() = default;

// Calls read() and adds scan and viewpoint to its errors.
template <class Read>
auto MatterportImages::with_context(ViewpointIndex viewpoint, const Read& read) const {
  EN_CHECK_LT(viewpoint.at(), size());
  const std::string place =
      fmt::format("scan {:?}, viewpoint {:?}", scan(), poses()[viewpoint.at()].viewpoint);
  try {
    return read();
  } catch (const InvalidInput& error) {
    std::vector<Diagnostic> diagnostics = error.diagnostics();
    for (Diagnostic& d : diagnostics) d.where = place + (d.where.empty() ? "" : ", ") + d.where;
    throw InvalidInput(std::move(diagnostics));
  } catch (const FileError& error) {
    throw FileError(fmt::format("{}\n({})", error.what(), place));
  }
}

FaceSizes MatterportImages::Impl::read_sizes(const std::string& viewpoint) const {
  FaceSizes found{};
  for (const Layer layer : {Layer::kColour, Layer::kDepth, Layer::kClass, Layer::kInstance}) {
    found[index(layer)] = skybox.size(layer, viewpoint);
  }
  // Depth is built at the size of the colour, which guides the filling of holes.
  const std::uint32_t colour = found[index(Layer::kColour)];
  std::uint32_t& depth = found[index(Layer::kDepth)];
  if (depth == 0 && colour != 0 && undistorted.contains(viewpoint)) depth = colour;
  return found;
}

std::optional<image::CubeMap<std::uint16_t>> MatterportImages::Impl::read_depth(
    const PanoramaPose& pose) const {
  if (auto strip = skybox.strip_16(Layer::kDepth, pose.viewpoint)) return strip;
  if (!undistorted.contains(pose.viewpoint)) return std::nullopt;
  const auto colour = skybox.colour(pose.viewpoint);
  if (!colour) return std::nullopt;
  return undistorted.read(pose, *colour);
}

FaceSizes MatterportImages::sizes_at(ViewpointIndex viewpoint) const {
  {
    const std::lock_guard lock(impl_->mutex);
    if (const auto& known = impl_->sizes[viewpoint.at()]) return *known;
  }
  const FaceSizes read = impl_->read_sizes(poses()[viewpoint.at()].viewpoint);
  const std::lock_guard lock(impl_->mutex);
  auto& first = impl_->sizes[viewpoint.at()];
  if (!first) first = read;
  return *first;
}

// The map, if it is there and has the size that face_sizes() gave.
template <class T>
image::CubeMap<T> MatterportImages::checked(Layer layer, ViewpointIndex viewpoint,
                                            std::optional<image::CubeMap<T>> map) const {
  if (!map) throw lacks(layer, viewpoint);
  const std::uint32_t size = sizes_at(viewpoint)[index(layer)];
  if ((*map)[0].width != size) {
    refuse(origin(), "", "changed",
           fmt::format("{}: faces of {} texels, but of {} when first looked at: the files were "
                       "changed",
                       to_string(layer), (*map)[0].width, size));
  }
  return *std::move(map);
}

std::string MatterportImages::tried(Layer layer, ViewpointIndex viewpoint) const {
  const std::string& id = poses()[viewpoint.at()].viewpoint;
  return "; tried:" + impl_->skybox.tried(layer, id) +
         (layer == Layer::kDepth ? impl_->undistorted.tried(id) : "");
}

std::shared_ptr<const MatterportImages> MatterportImages::open(const fs::path& root,
                                                               const fs::path& connectivity,
                                                               const std::string& scan) {
  std::string tried, ignored;
  KindOfFiles skybox = find_kind(root, scan, "matterport_skybox_images", tried);
  if (skybox.empty()) {
    throw LookupError(
        fmt::format("scan {:?}: no panoramas; tried as folders and zip files:{}", scan, tried));
  }
  std::vector<PanoramaPose> poses = poses_of(load_connectivity(connectivity, scan));
  std::unique_ptr<Impl> impl(
      new Impl{connectivity,
               detail::SkyboxFiles(std::move(skybox)),
               {scan, find_kind(root, scan, "undistorted_camera_parameters", ignored),
                find_kind(root, scan, "undistorted_depth_images", ignored)}});
  return std::shared_ptr<const MatterportImages>(
      new MatterportImages(std::move(impl), root.string(), std::move(poses), scan));
}

Connectivity MatterportImages::connectivity() const {
  return load_connectivity(impl_->connectivity, scan());
}

FaceSizes MatterportImages::face_sizes(ViewpointIndex viewpoint) const {
  return with_context(viewpoint, [&] { return sizes_at(viewpoint); });
}

void MatterportImages::read(Layer layer, ViewpointIndex viewpoint, FaceMask wanted,
                            const FaceBuffers& buffers) const {
  const auto good = [&](auto map) { return checked(layer, viewpoint, std::move(map)); };
  with_context(viewpoint, [&] {
    const PanoramaPose& pose = poses()[viewpoint.at()];
    const detail::SkyboxFiles& skybox = impl_->skybox;
    switch (layer) {
      case Layer::kColour:
        return image::write_faces(good(skybox.colour(pose.viewpoint)), wanted,
                                  std::get<ColourFaces>(buffers));
      case Layer::kDepth:
        return image::copy_faces(good(impl_->read_depth(pose)), wanted, std::get<Faces16>(buffers));
      case Layer::kClass:
        return image::copy_faces(good(skybox.strip_16(layer, pose.viewpoint)), wanted,
                                 std::get<Faces16>(buffers));
      case Layer::kInstance:
        return image::copy_faces(good(skybox.instances(pose.viewpoint)), wanted,
                                 std::get<Faces32>(buffers));
    }
  });
}

std::optional<std::array<std::string, kCubeFaces>> MatterportImages::colour_jpegs(
    ViewpointIndex viewpoint) const {
  return with_context(viewpoint, [&] {
    const std::string& id = poses()[viewpoint.at()].viewpoint;
    auto jpegs = impl_->skybox.colour_jpegs(id);
    if (!jpegs && impl_->skybox.size(Layer::kColour, id) == 0) {
      throw lacks(Layer::kColour, viewpoint);
    }
    return jpegs;
  });
}

std::string MatterportImages::state() const {
  return impl_->skybox.state() + impl_->undistorted.state();
}

}  // namespace enfilade::scan
