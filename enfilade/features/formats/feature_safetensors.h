/// \file  Features as safetensors: one array per viewpoint.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/core/mapped_file.h"
#include "enfilade/features/formats/feature_rows.h"

namespace enfilade::features::formats {

/// Maps a file. \throws FileError, InvalidInput
FeatureRows read_feature_safetensors(const std::filesystem::path& file);

/// The same for a mapped file. \param map is kept by the result \param name for messages
FeatureRows feature_rows_of(const std::shared_ptr<const MappedFile>& map, const std::string& name);

/// Continues a part of the same info and keys. \throws FileError, ArgumentError
std::unique_ptr<RowWriter> write_feature_safetensors(const std::filesystem::path& file,
                                                     const FeatureInfo& info,
                                                     const std::vector<FeatureKey>& keys);

}  // namespace enfilade::features::formats
