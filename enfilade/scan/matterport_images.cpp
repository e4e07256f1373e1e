#include "enfilade/scan/matterport_images.h"

#include <fmt/format.h>
#include <array>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/scan/detail/panorama_files.h"

namespace enfilade::scan {
namespace {

namespace fs = std::filesystem;
using detail::KindOfFiles;

/// The existing folders and zip files of one kind. \param tried gets all places, unless it is null
KindOfFiles find_kind(const fs::path& root, const std::string& scan, const std::string& kind,
                      std::string* tried = nullptr) {
  std::vector<std::shared_ptr<const FileTree>> trees;
  for (const fs::path& place : {root / scan / kind, root / "v1" / "scans" / scan / kind,
                                root / "scans" / scan / kind, root / kind}) {
    const std::string zip = place.string() + ".zip";
    std::error_code ignored;
    if (fs::is_directory(place, ignored)) trees.push_back(FileTree::folder(place));
    if (fs::is_regular_file(zip, ignored)) trees.push_back(FileTree::zip(zip));
    if (tried != nullptr) *tried += fmt::format("\n  {}\n  {}", place.string(), zip);
  }
  return KindOfFiles(std::move(trees));
}

/// Reads the files when they are asked for.
class MatterportImages final : public PanoramaSource {
 public:
  MatterportImages(const fs::path& root, fs::path connectivity, const std::string& scan,
                   KindOfFiles skybox)
      : PanoramaSource(scan, root.string(), poses_of(load_connectivity(connectivity, scan))),
        connectivity_(std::move(connectivity)),
        skybox_(std::move(skybox)),
        undistorted_(scan, find_kind(root, scan, "undistorted_camera_parameters"),
                     find_kind(root, scan, "undistorted_depth_images")),
        sizes_(size()) {}

  Connectivity connectivity() const override { return load_connectivity(connectivity_, scan()); }
  FaceSizes face_sizes(ViewpointIndex viewpoint) const override {
    return with_context(viewpoint, [&] { return sizes_at(viewpoint); });
  }
  bool reads_whole_panoramas() const noexcept override { return true; }
  // JPEG files of faces unchanged, or a strip's, cut between its blocks (image::cut_jpeg_strip).
  std::optional<std::array<std::string, kCubeFaces>> colour_jpegs(
      ViewpointIndex viewpoint) const override {
    return with_context(viewpoint, [&] {
      const std::string& id = poses()[viewpoint.at()].viewpoint;
      auto jpegs = skybox_.colour_jpegs(id);
      if (!jpegs && skybox_.size(Layer::kColour, id) == 0) {
        throw lacks(Layer::kColour, viewpoint);
      }
      return jpegs;
    });
  }

  std::string state() const override { return skybox_.state() + undistorted_.state(); }
  std::string tried(Layer layer, ViewpointIndex viewpoint) const override {
    const std::string& id = poses()[viewpoint.at()].viewpoint;
    return "; tried:" + skybox_.tried(layer, id) +
           (layer == Layer::kDepth ? undistorted_.tried(id) : "");
  }

 private:
  void read(Layer layer, ViewpointIndex viewpoint, FaceMask wanted,
            const FaceBuffers& buffers) const override {
    const auto good = [&](auto map) { return checked(layer, viewpoint, std::move(map)); };
    with_context(viewpoint, [&] {
      const PanoramaPose& pose = poses()[viewpoint.at()];
      switch (layer) {
        case Layer::kColour:
          return image::write_faces(good(skybox_.colour(pose.viewpoint)), wanted,
                                    std::get<ColourFaces>(buffers));
        case Layer::kDepth:
          return image::copy_faces(good(read_depth(pose)), wanted, std::get<Faces16>(buffers));
        case Layer::kClass:
          return image::copy_faces(good(skybox_.strip_16(layer, pose.viewpoint)), wanted,
                                   std::get<Faces16>(buffers));
        case Layer::kInstance:
          return image::copy_faces(good(skybox_.instances(pose.viewpoint)), wanted,
                                   std::get<Faces32>(buffers));
      }
    });
  }

  // Calls read() and adds scan and viewpoint to its errors.
  template <class Read>
  auto with_context(ViewpointIndex viewpoint, const Read& read) const -> decltype(read()) {
    EN_CHECK_LT(viewpoint.at(), size());
    const std::string place = fmt::format("scan {}, viewpoint {}", quote(scan()),
                                          quote(poses()[viewpoint.at()].viewpoint));
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

  FaceSizes read_sizes(const std::string& viewpoint) const {
    FaceSizes found{};
    for (const Layer layer : {Layer::kColour, Layer::kDepth, Layer::kClass, Layer::kInstance}) {
      found[index(layer)] = skybox_.size(layer, viewpoint);
    }
    // Depth is built at the size of the colour, which guides the filling of holes.
    const std::uint32_t colour = found[index(Layer::kColour)];
    std::uint32_t& depth = found[index(Layer::kDepth)];
    if (depth == 0 && colour != 0 && undistorted_.contains(viewpoint)) depth = colour;
    return found;
  }

  std::optional<image::CubeMap<std::uint16_t>> read_depth(const PanoramaPose& pose) const {
    if (auto strip = skybox_.strip_16(Layer::kDepth, pose.viewpoint)) return strip;
    if (!undistorted_.contains(pose.viewpoint)) return std::nullopt;
    const auto colour = skybox_.colour(pose.viewpoint);
    if (!colour) return std::nullopt;
    return undistorted_.read(pose, *colour);
  }

  FaceSizes sizes_at(ViewpointIndex viewpoint) const {
    {
      const std::lock_guard lock(mutex_);
      if (const auto& known = sizes_[viewpoint.at()]) return *known;
    }
    const FaceSizes read = read_sizes(poses()[viewpoint.at()].viewpoint);
    const std::lock_guard lock(mutex_);
    auto& first = sizes_[viewpoint.at()];
    if (!first) first = read;
    return *first;
  }

  // The map, if it is there and has the size that face_sizes() gave.
  template <class T>
  image::CubeMap<T> checked(Layer layer, ViewpointIndex viewpoint,
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

  fs::path connectivity_;  ///< folder
  detail::SkyboxFiles skybox_;
  detail::UndistortedDepth undistorted_;
  mutable std::mutex mutex_;
  /// The first result of face_sizes(), which callers allocate buffers by; files that change later
  /// must not change it.
  mutable std::vector<std::optional<FaceSizes>> sizes_;
};

}  // namespace

std::shared_ptr<const PanoramaSource> open_matterport_images(const fs::path& root,
                                                             const fs::path& connectivity,
                                                             const std::string& scan) {
  std::string tried;
  KindOfFiles skybox = find_kind(root, scan, "matterport_skybox_images", &tried);
  if (skybox.empty()) {
    throw LookupError(fmt::format("scan {}: no panoramas; tried as folders and zip files:{}",
                                  quote(scan), tried));
  }
  return std::make_shared<MatterportImages>(root, connectivity, scan, std::move(skybox));
}

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
