/// \file  Features as HDF5: a dataset a viewpoint, as HAMT, DUET and others keep them.
#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "enfilade/features/formats/feature_rows.h"

namespace enfilade::features::formats {

// The HDF5 library is not for several threads: all calls into it are one behind the other here.
// What it would print of its errors is turned off while we are in it.

/// Read into memory, by a copy of this process: the library has bugs that damaged files find.
/// \throws FileError; InvalidInput naming the dataset
FeatureRows read_feature_hdf5(const std::filesystem::path& file);

/// Begins anew. \throws FileError
std::unique_ptr<RowWriter> write_feature_hdf5(const std::filesystem::path& file,
                                              const FeatureInfo& info,
                                              const std::vector<FeatureKey>& keys);

}  // namespace enfilade::features::formats
