/// \file  Features of objects, by the viewpoint that they are seen from.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "enfilade/geometry/angle.h"

namespace enfilade::features {

/// An object as one viewpoint shows it.
struct ObjectView {
  std::string id;
  Radians heading, elevation;    ///< of its middle, in the world
  double width = 0, height = 0;  ///< pixels, of a picture of 640 x 480
};

/// The objects of viewpoints with their features, in the published format of REVERIE and SOON:
/// HDF5. A viewpoint with objects has a dataset "<scan>_<viewpoint>" of (objects, dimensions)
/// numbers. Its attributes are `obj_ids`, `directions` (heading and elevation, radians) and `sizes`
/// (width and height) of the objects. SOON has `bboxes` (left, top, right, bottom, in pictures of
/// 600 x 600) instead of sizes. Immutable: any thread may read.
class ObjectSet {
 public:
  /// Reads into memory.
  /// \throws FileError
  /// \throws InvalidInput naming the viewpoint, for missing attributes, another number of objects,
  /// sizes that differ, and numbers that are not finite
  static ObjectSet open(const std::filesystem::path& file);

  std::size_t dimensions() const noexcept;  ///< per object
  const std::filesystem::path& file() const noexcept;
  /// In the file's order. Empty for viewpoints that are not there. Valid as long as *this.
  std::span<const ObjectView> objects(std::string_view scan, std::string_view viewpoint) const;
  /// The first out.size() numbers of object `i`.
  /// \pre i < objects(scan, viewpoint).size(), out.size() <= dimensions()
  /// \throws InvalidInput if one of them is not finite
  void copy(std::string_view scan, std::string_view viewpoint, std::size_t i,
            std::span<float> out) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace enfilade::features
