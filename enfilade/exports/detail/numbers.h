/// \file  Numbers as an HDF5 file stores them, and attributes that all files of features have.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "enfilade/features/hdf5_writer.h"
#include "enfilade/geometry/camera.h"

namespace enfilade::exports::detail {

/// Memory for numbers of one type.
class StoredNumbers {
 public:
  /// \throws ArgumentError unless it is kFloat16, kFloat32 or kFloat64
  explicit StoredNumbers(features::Hdf5Type type);
  /// Valid until the next call, and as long as `numbers`. \throws ArgumentError naming `where`, for
  /// a number that is too large for the type
  std::span<const std::byte> store(std::span<const float> numbers, const std::string& where);
  features::Hdf5Type type() const noexcept { return type_; }

 private:
  features::Hdf5Type type_;
  std::vector<std::uint16_t> halves_;
  std::vector<double> doubles_;
};

/// The mean of the readings in each cell of square pictures, in units of `unit`; a reading beyond
/// one unit counts as one. 0 is no reading, and the value of a cell without any.
/// \param depths (pictures, cells * cell, cells * cell), metres; cell: pixels across
/// \param out (pictures, cells, cells)
void pool_depth(std::span<const float> depths, std::size_t pictures, std::size_t cells,
                std::size_t cell, float unit, std::span<float> out);

/// scanId, viewpointId, image_w, image_h, vfov in degrees: whole numbers as integers.
std::vector<features::Hdf5Attribute> view_attributes(const std::string& scan,
                                                     const std::string& viewpoint,
                                                     const Camera& camera);

}  // namespace enfilade::exports::detail
