/// \file  What readers and writers of the formats of features have in common.
#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/features/feature_set.h"

namespace enfilade::features::formats {

/// A set as read: a row a viewpoint, info.views x info.dimensions numbers of info.type.
struct FeatureRows {
  FeatureInfo info;
  std::vector<FeatureKey> keys;
  std::vector<const std::byte*> rows;
  std::vector<std::shared_ptr<const void>> memory;  ///< that they lie in
};

std::size_t row_elements(const FeatureInfo& info) noexcept;
std::size_t row_bytes(const FeatureInfo& info) noexcept;

/// "<scan>_<viewpoint>", as arrays and datasets are called.
std::string name_of(const FeatureKey& key);
/// Viewpoints have no "_", scans may. \throws InvalidInput
FeatureKey key_of(std::string_view name, const std::string& file);

/// Of all but the shape and type, in words; equal where these are equal.
std::map<std::string, std::string> metadata_of(const FeatureInfo& info);
/// What metadata does not say stays as it is. \throws InvalidInput
void read_metadata(const std::map<std::string, std::string>& metadata, const std::string& file,
                   FeatureInfo& info);
/// A number as in a TSV or metadata. \throws InvalidInput naming `where`
double parse_number(std::string_view text, const std::string& file, const std::string& where);
/// \param degrees vertical. \throws InvalidInput naming `where`
Camera make_camera(double width, double height, double degrees, const std::string& file,
                   const std::string& where);
/// Without the noise of a conversion to radians and back: "60".
std::string degrees_text(Radians angle);

/// Where a FeatureWriter's rows go.
class RowWriter {
 public:
  virtual ~RowWriter() = default;
  virtual bool written(std::size_t row) const = 0;  ///< by an earlier run
  /// Of the right size, each number finite as it will be stored.
  virtual void write(std::size_t row, std::span<const float> views) = 0;
  virtual void finish() = 0;
};

}  // namespace enfilade::features::formats
