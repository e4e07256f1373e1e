/// \file  Features as base64 in tab-separated rows, as published with Room-to-Room.
#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "enfilade/features/formats/feature_rows.h"

namespace enfilade::features::formats {

inline constexpr std::size_t kTsvViews = 36;  ///< the format does not say how many

/// Reads a file into memory, on all cores. \throws FileError, InvalidInput naming row and viewpoint
FeatureRows read_feature_tsv(const std::filesystem::path& file);

/// Begins a new file. \throws FileError; ArgumentError for other than 36 views or 32 bit floats
std::unique_ptr<RowWriter> write_feature_tsv(const std::filesystem::path& file,
                                             const FeatureInfo& info,
                                             const std::vector<FeatureKey>& keys);

}  // namespace enfilade::features::formats
