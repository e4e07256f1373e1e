#include "enfilade/scan/detail/panorama_files.h"

#include <fmt/format.h>
#include <algorithm>

#include "enfilade/core/errors.h"
#include "enfilade/image/codecs.h"
#include "enfilade/scan/depth_skybox.h"
#include "enfilade/scan/matterport_images.h"

namespace enfilade::scan::detail {
namespace {

using image::bytes_of;
using image::Shape;

/// What is read of a file for its shape, bytes. Larger than the header of any picture without an
/// embedded thumbnail or colour profile.
constexpr std::size_t kHeaderBytes = std::size_t{16} << 10;

/// The shape of a picture and its file's path, from the start of the file if that suffices; empty
/// if there is no such file.
template <class ShapeOf>
std::pair<Shape, std::string> shape_of_file(const KindOfFiles& files, const std::string& name,
                                            const ShapeOf& shape_of) {
  auto file = files.read(name, kHeaderBytes);
  if (!file) return {};
  try {
    return {shape_of(bytes_of(file->bytes), file->path), file->path};
  } catch (const InvalidInput&) {  // a longer header or a broken file: read all
    file = files.read(name);
    if (!file) return {};
    return {shape_of(bytes_of(file->bytes), file->path), file->path};
  }
}

std::uint32_t check_strip(const Shape& shape, const std::string& file) {
  if (shape.width != std::uint64_t{6} * shape.height) {
    refuse(file, "", "bad-strip",
           fmt::format("{} x {} pixels, not six square faces side by side", shape.width,
                       shape.height));
  }
  return shape.height;
}

/// Checks that faces are square and have the size of the first one.
class FaceCheck {
 public:
  void check(std::uint32_t width, std::uint32_t height, const std::string& file) {
    if (width != height) {
      refuse(file, "", "bad-face", fmt::format("{} x {} pixels, not square", width, height));
    }
    if (size_ == 0) size_ = width, first_ = file;
    if (width == size_) return;
    refuse(file, "", "mixed-sizes",
           fmt::format("{} pixels wide, but {} is {}: the six faces of a panorama are of one size",
                       width, first_, size_));
  }
  std::uint32_t size() const { return size_; }

 private:
  std::uint32_t size_ = 0;
  std::string first_;
};

/// Checks the channels and bits of a strip of depth, classes or instances.
void check_grey(Layer layer, const Shape& shape, const std::string& file) {
  const bool grey = shape.channels == 1;
  if (layer == Layer::kDepth && !(grey && shape.bits == 16)) {
    refuse(file, "", "bad-bits",
           fmt::format("{} channels of {} bits, not greyscale of 16 bits", shape.channels,
                       shape.bits));
  }
  if (layer == Layer::kClass && !grey) {
    refuse(file, "", "bad-colours", fmt::format("{} channels, not greyscale", shape.channels));
  }
  if (layer == Layer::kInstance && !grey && !(shape.channels == 4 && shape.bits == 8)) {
    refuse(file, "", "bad-colours",
           fmt::format("{} channels of {} bits, neither greyscale nor RGBA of 8 bits",
                       shape.channels, shape.bits));
  }
}

}  // namespace

// --- KindOfFiles ----------------------------------------------------------------------------

bool KindOfFiles::contains(std::string_view name) const {
  return std::ranges::any_of(trees_, [&](const auto& tree) { return tree->contains(name); });
}

std::optional<FoundFile> KindOfFiles::read(std::string_view name, std::size_t bytes) const {
  for (const auto& tree : trees_) {
    if (auto start = tree->read_start(name, bytes)) {
      return FoundFile{tree->path_of(name), *std::move(start)};
    }
  }
  return std::nullopt;
}

std::string KindOfFiles::tried(std::string_view name) const {
  std::string text;
  for (const auto& tree : trees_) text += "\n  " + tree->path_of(name);
  return text;
}

std::string KindOfFiles::state() const {
  std::string text;
  for (const auto& tree : trees_) text += tree->state();
  return text;
}

// --- SkyboxFiles ----------------------------------------------------------------------------

bool SkyboxFiles::has_faces(const std::string& viewpoint) const {
  std::size_t found = 0;
  std::string missing;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const std::string name = skybox_face_name(viewpoint, k);
    if (files_.contains(name)) {
      ++found;
    } else {
      missing = name;
    }
  }
  if (found != 0 && found != kCubeFaces) {
    throw FileError(
        fmt::format("{}: no such file, though {} of the panorama's 6 faces are there; tried:{}",
                    missing, found, files_.tried(missing)));
  }
  return found != 0;
}

std::uint32_t SkyboxFiles::size(Layer layer, const std::string& viewpoint) const {
  const std::string name = skybox_strip_name(viewpoint, layer);
  if (files_.contains(name)) {
    const auto [shape, path] =
        shape_of_file(files_, name, layer == Layer::kColour ? image::jpeg_shape : image::png_shape);
    if (layer != Layer::kColour) check_grey(layer, shape, path);
    return check_strip(shape, path);
  }
  if (layer != Layer::kColour || !has_faces(viewpoint)) return 0;
  FaceCheck faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const auto [shape, path] =
        shape_of_file(files_, skybox_face_name(viewpoint, k), image::jpeg_shape);
    faces.check(shape.width, shape.height, path);
  }
  return faces.size();
}

std::optional<image::CubeMap<std::uint8_t>> SkyboxFiles::colour(
    const std::string& viewpoint) const {
  if (const auto strip = files_.read(skybox_strip_name(viewpoint, Layer::kColour))) {
    const auto picture = image::decode_jpeg(bytes_of(strip->bytes), strip->path);
    check_strip({picture.width, picture.height, 3, 8}, strip->path);
    return image::split_strip(picture);
  }
  if (!has_faces(viewpoint)) return std::nullopt;
  image::CubeMap<std::uint8_t> faces;
  FaceCheck all;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const auto file = files_.read(skybox_face_name(viewpoint, k));
    if (!file) return std::nullopt;
    faces[k] = image::decode_jpeg(bytes_of(file->bytes), file->path);
    all.check(faces[k].width, faces[k].height, file->path);
  }
  return faces;
}

std::optional<FoundFile> SkyboxFiles::png_strip(Layer layer, const std::string& viewpoint) const {
  auto file = files_.read(skybox_strip_name(viewpoint, layer));
  if (!file) return std::nullopt;
  const Shape shape = image::png_shape(bytes_of(file->bytes), file->path);
  check_grey(layer, shape, file->path);
  check_strip(shape, file->path);
  return file;
}

std::optional<image::CubeMap<std::uint16_t>> SkyboxFiles::strip_16(
    Layer layer, const std::string& viewpoint) const {
  const auto file = png_strip(layer, viewpoint);
  if (!file) return std::nullopt;
  return image::split_strip(image::decode_png16(bytes_of(file->bytes), file->path));
}

std::optional<image::CubeMap<std::uint32_t>> SkyboxFiles::instances(
    const std::string& viewpoint) const {
  const auto file = png_strip(Layer::kInstance, viewpoint);
  if (!file) return std::nullopt;
  return image::split_strip(image::decode_ids(bytes_of(file->bytes), file->path));
}

std::optional<std::array<std::string, kCubeFaces>> SkyboxFiles::colour_jpegs(
    const std::string& viewpoint) const {
  std::array<std::string, kCubeFaces> jpegs;
  if (const auto strip = files_.read(skybox_strip_name(viewpoint, Layer::kColour))) {
    const auto cut = image::cut_jpeg_strip(bytes_of(strip->bytes), strip->path);
    if (!cut) return std::nullopt;
    for (std::size_t k = 0; k < kCubeFaces; ++k)
      jpegs[k].assign((*cut)[k].begin(), (*cut)[k].end());
    return jpegs;
  }
  if (!has_faces(viewpoint)) return std::nullopt;
  FaceCheck faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    auto file = files_.read(skybox_face_name(viewpoint, k));
    if (!file) return std::nullopt;
    const Shape shape = image::jpeg_shape(bytes_of(file->bytes), file->path);
    faces.check(shape.width, shape.height, file->path);
    jpegs[k] = std::move(file->bytes);
  }
  return jpegs;
}

std::string SkyboxFiles::tried(Layer layer, const std::string& viewpoint) const {
  std::string text = files_.tried(skybox_strip_name(viewpoint, layer));
  if (layer == Layer::kColour) text += files_.tried(viewpoint + "_skybox<0..5>_sami.jpg");
  return text;
}

// --- UndistortedDepth -----------------------------------------------------------------------

const std::vector<UndistortedCamera>& UndistortedDepth::cameras(
    const std::string& viewpoint) const {
  const std::lock_guard lock(mutex_);
  if (!cameras_) {
    Cameras all;
    if (const auto file = parameters_.read(name_)) {
      for (auto& camera : parse_undistorted_cameras(file->bytes, file->path)) {
        const std::string of(camera.viewpoint());
        all[of].push_back(std::move(camera));
      }
    }
    cameras_ = std::move(all);
  }
  static const std::vector<UndistortedCamera> kNone;
  const auto found = cameras_->find(viewpoint);
  return found == cameras_->end() ? kNone : found->second;
}

bool UndistortedDepth::contains(const std::string& viewpoint) const {
  const auto& all = cameras(viewpoint);
  return !all.empty() && images_.contains(all.front().depth_file);
}

image::CubeMap<std::uint16_t> UndistortedDepth::read(
    const PanoramaPose& eye, const image::CubeMap<std::uint8_t>& colour) const {
  std::vector<DepthImage> images;
  for (const UndistortedCamera& camera : cameras(eye.viewpoint)) {
    const auto file = images_.read(camera.depth_file);
    if (!file) {
      throw FileError(fmt::format("{}: no such file, though {} lists it; tried:{}",
                                  camera.depth_file, name_, images_.tried(camera.depth_file)));
    }
    check_grey(Layer::kDepth, image::png_shape(bytes_of(file->bytes), file->path), file->path);
    images.push_back({camera, image::decode_png16(bytes_of(file->bytes), file->path)});
  }
  return fill_holes(depth_skybox(images, eye, colour[0].width, 1), colour, 1);
}

std::string UndistortedDepth::tried(const std::string& viewpoint) const {
  return parameters_.tried(name_) + images_.tried(viewpoint + "_d<cam>_<yaw>.png");
}

}  // namespace enfilade::scan::detail
