/// \file  Finds and reads the pictures of viewpoints by Matterport3D's file names.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "enfilade/image/image.h"
#include "enfilade/scan/file_tree.h"
#include "enfilade/scan/matterport_cameras.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::scan::detail {

/// A file that was found, and its name for messages.
struct FoundFile {
  std::string path;
  std::string bytes;
};

/// The folders and zip files that may hold the files of one kind. A file is read from the first
/// that has it.
class KindOfFiles {
 public:
  KindOfFiles() = default;
  explicit KindOfFiles(std::vector<std::shared_ptr<const FileTree>> trees)
      : trees_(std::move(trees)) {}

  bool empty() const { return trees_.empty(); }
  bool contains(std::string_view name) const;
  /// The file, or at most that many bytes from its start.
  std::optional<FoundFile> read(std::string_view name, std::size_t bytes = std::string::npos) const;
  /// The paths that were tried, one per line, indented.
  std::string tried(std::string_view name) const;
  std::string state() const;  ///< as FileTree's

 private:
  std::vector<std::shared_ptr<const FileTree>> trees_;
};

/// `matterport_skybox_images`. All functions may be called from any thread. Errors name the file.
class SkyboxFiles {
 public:
  SkyboxFiles() = default;
  explicit SkyboxFiles(KindOfFiles files) : files_(std::move(files)) {}

  /// Edge length of a face, from headers alone; 0 if there is no such picture (none of six faces).
  /// \throws FileError, InvalidInput
  std::uint32_t size(Layer layer, const std::string& viewpoint) const;
  /// No value if there is no file. \throws FileError, InvalidInput
  std::optional<image::CubeMap<std::uint8_t>> colour(const std::string& viewpoint) const;
  std::optional<image::CubeMap<std::uint16_t>> strip_16(Layer layer,
                                                        const std::string& viewpoint) const;
  std::optional<image::CubeMap<std::uint32_t>> instances(const std::string& viewpoint) const;
  /// As PanoramaSource's; no value also if there are no pictures.
  std::optional<std::array<std::string, kCubeFaces>> colour_jpegs(
      const std::string& viewpoint) const;
  /// The paths that were tried for a layer's files, one per line, indented.
  std::string tried(Layer layer, const std::string& viewpoint) const;
  std::string state() const { return files_.state(); }

 private:
  bool has_faces(const std::string& viewpoint) const;
  std::optional<FoundFile> png_strip(Layer layer, const std::string& viewpoint) const;
  KindOfFiles files_;
};

/// `undistorted_camera_parameters` and `undistorted_depth_images`. From any thread.
class UndistortedDepth {
 public:
  UndistortedDepth(std::string scan, KindOfFiles parameters, KindOfFiles images)
      : name_(std::move(scan) + ".conf"),
        parameters_(std::move(parameters)),
        images_(std::move(images)) {}

  /// Whether there are a camera and its picture. The first call reads the cameras of all
  /// viewpoints. \throws FileError, InvalidInput
  bool contains(const std::string& viewpoint) const;
  /// Builds the sky-box and fills its holes, on the calling thread only, as callers process many
  /// viewpoints in parallel.
  /// \pre contains(eye.viewpoint)
  /// \throws FileError if a camera's picture is missing; InvalidInput
  image::CubeMap<std::uint16_t> read(const PanoramaPose& eye,
                                     const image::CubeMap<std::uint8_t>& colour) const;
  std::string tried(const std::string& viewpoint) const;
  std::string state() const { return parameters_.state() + images_.state(); }

 private:
  using Cameras = std::unordered_map<std::string, std::vector<UndistortedCamera>>;
  const std::vector<UndistortedCamera>& cameras(const std::string& viewpoint) const;

  std::string name_;
  KindOfFiles parameters_, images_;
  mutable std::mutex mutex_;
  mutable std::optional<Cameras> cameras_;  ///< set once, under the mutex
};

}  // namespace enfilade::scan::detail
