/// \file  The common part of the readers and writers of feature files.
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

/// A set that was read: one row per viewpoint, of info.views x info.dimensions numbers of
/// info.type.
struct FeatureRows {
  FeatureInfo info;
  std::vector<FeatureKey> keys;
  std::vector<const std::byte*> rows;
  std::vector<std::shared_ptr<const void>> memory;  ///< of the rows
};

std::size_t row_elements(const FeatureInfo& info) noexcept;
std::size_t row_bytes(const FeatureInfo& info) noexcept;

/// "<scan>_<viewpoint>", the name of its array or dataset.
std::string name_of(const FeatureKey& key);
/// The reverse: viewpoints have no "_", scans may. \throws InvalidInput
FeatureKey key_of(std::string_view name, const std::string& file);

/// Everything but shape and type, as texts; equal texts for equal values.
std::map<std::string, std::string> metadata_of(const FeatureInfo& info);
/// Sets `info` from metadata; what is missing there stays as it is. \throws InvalidInput
void read_metadata(const std::map<std::string, std::string>& metadata, const std::string& file,
                   FeatureInfo& info);
/// A number as in a TSV or metadata. \throws InvalidInput naming `where`
double parse_number(std::string_view text, const std::string& file, const std::string& where);
/// \param degrees vertical. \throws InvalidInput naming `where`
Camera make_camera(double width, double height, double degrees, const std::string& file,
                   const std::string& where);
/// Degrees without the rounding error of a conversion to radians and back: "60".
std::string degrees_text(Radians angle);

/// Writes the rows of a FeatureWriter.
class RowWriter {
 public:
  virtual ~RowWriter() = default;
  virtual bool written(std::size_t row) const = 0;  ///< by an earlier run
  /// \pre views has the right size, and each number is finite in the stored type
  virtual void write(std::size_t row, std::span<const float> views) = 0;
  virtual void finish() = 0;
};

}  // namespace enfilade::features::formats
