/// \file  Features as HDF5: one dataset per viewpoint, as in HAMT, DUET and others.
#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "enfilade/features/formats/feature_rows.h"

namespace enfilade::features::formats {

// The HDF5 library is not thread-safe: calls into it are serialised here. Its own printing of
// errors is turned off meanwhile.

/// Reads a file into memory, in a forked copy of this process, as damaged files can crash the
/// library. \throws FileError; InvalidInput naming the dataset
FeatureRows read_feature_hdf5(const std::filesystem::path& file);

/// Begins anew. \throws FileError
std::unique_ptr<RowWriter> write_feature_hdf5(const std::filesystem::path& file,
                                              const FeatureInfo& info,
                                              const std::vector<FeatureKey>& keys);

}  // namespace enfilade::features::formats
