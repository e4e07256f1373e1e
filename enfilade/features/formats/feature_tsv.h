/// \file  Features as base64 in tab-separated rows, as the authors of Room-to-Room published
/// theirs.
#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "enfilade/features/formats/feature_rows.h"

namespace enfilade::features::formats {

inline constexpr std::size_t kTsvViews = 36;  ///< which the format does not say

/// Read into memory on all cores. \throws FileError, InvalidInput naming row and viewpoint
FeatureRows read_feature_tsv(const std::filesystem::path& file);

/// Begins anew. \throws FileError; ArgumentError for other than 36 views or 32 bit floats
std::unique_ptr<RowWriter> write_feature_tsv(const std::filesystem::path& file,
                                             const FeatureInfo& info,
                                             const std::vector<FeatureKey>& keys);

}  // namespace enfilade::features::formats
