/// \file  Objects of viewpoints from HDF5.
#pragma once
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/mapped_file.h"
#include "enfilade/features/object_set.h"

namespace enfilade::features::formats {

/// The objects of one viewpoint.
struct ViewpointObjects {
  std::string name;  ///< "<scan>_<viewpoint>"
  std::vector<ObjectView> objects;
  std::span<const std::byte> numbers;  ///< (objects, dimensions) of float32
};

struct ObjectRows {
  std::size_t dimensions = 0;
  std::vector<ViewpointObjects> viewpoints;
  std::shared_ptr<const MappedFile> memory;
};

/// Reads in a forked copy of this process, as damaged files can crash the library.
/// \throws FileError, InvalidInput
ObjectRows read_object_hdf5(const std::filesystem::path& file);

}  // namespace enfilade::features::formats
