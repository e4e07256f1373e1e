/// \file  Readers and writers of feature files, one pair a format, and what they share.
#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/mapped_file.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/features/formats/stored_arrays.h"

namespace enfilade::features::formats {

/// A set that was read: one row per viewpoint, of info.views x info.dimensions numbers of
/// info.type.
struct FeatureRows {
  FeatureInfo info;
  std::vector<FeatureKey> keys;
  std::vector<const std::byte*> rows;
  std::vector<std::shared_ptr<const void>> memory;  ///< of the rows
};

/// Writes the rows of a FeatureWriter.
class RowWriter {
 public:
  virtual ~RowWriter() = default;
  /// Whether an earlier run wrote it.
  virtual bool written(std::size_t /*row*/) const { return false; }
  /// \pre views has the right size, and each number is finite in the stored type
  virtual void write(std::size_t row, std::span<const float> views) = 0;
  virtual void finish() = 0;
};

// Readers throw FileError, and InvalidInput that names the array, dataset or row. Writers throw
// FileError, and ArgumentError for what their format cannot hold.

/// Safetensors with an array per viewpoint. Maps the file.
FeatureRows read_feature_safetensors(const std::filesystem::path& file);
/// The same for a mapped file. \param map is kept by the result \param name for messages
FeatureRows feature_rows_of(const std::shared_ptr<const MappedFile>& map, const std::string& name);
/// Continues a part of the same info and keys.
std::unique_ptr<RowWriter> write_feature_safetensors(const std::filesystem::path& file,
                                                     const FeatureInfo& info,
                                                     const std::vector<FeatureKey>& keys);

/// Base64 in tab-separated rows, as published with Room-to-Room. Reads into memory, on all cores.
FeatureRows read_feature_tsv(const std::filesystem::path& file);
/// Begins a new file. \throws ArgumentError for other than 36 views of 32 bit floats
std::unique_ptr<RowWriter> write_feature_tsv(const std::filesystem::path& file,
                                             const FeatureInfo& info,
                                             const std::vector<FeatureKey>& keys);

/// HDF5 with a dataset per viewpoint, as in HAMT, DUET and others. Reads into memory, in a forked
/// copy of this process, as damaged files can crash the library. The library is not thread-safe:
/// calls into it are serialised, and its own printing of errors is turned off meanwhile.
FeatureRows read_feature_hdf5(const std::filesystem::path& file);
/// Begins a new file.
std::unique_ptr<RowWriter> write_feature_hdf5(const std::filesystem::path& file,
                                              const FeatureInfo& info,
                                              const std::vector<FeatureKey>& keys);

// --- what they share ---

std::size_t row_elements(const FeatureInfo& info) noexcept;
std::size_t row_bytes(const FeatureInfo& info) noexcept;

/// "<scan>_<viewpoint>", the name of its array or dataset.
std::string name_of(const FeatureKey& key);
/// The reverse (underscore_between_ids()). Ids may have "_", so rows are found by name_of(), not by
/// the parts. \throws InvalidInput, also if they are no ids (core/names.h)
FeatureKey key_of(std::string_view name, const std::string& file);
/// \throws InvalidInput with the code `bad-id`
void check_key(const FeatureKey& key, const std::string& file, const std::string& where);

/// The start of a name in quotes, for messages.
std::string in_quotes(std::string_view name);

/// Everything but shape and type, as texts; equal texts for equal values.
std::map<std::string, std::string> metadata_of(const FeatureInfo& info);
/// The layout of a safetensors file of these features.
SafetensorsLayout lay_out_features(const FeatureInfo& info, const std::vector<FeatureKey>& keys);
/// Sets `info` from metadata; missing fields do not change. \throws InvalidInput
void read_metadata(const std::map<std::string, std::string>& metadata, const std::string& file,
                   FeatureInfo& info);
/// A number as in a TSV or metadata. \throws InvalidInput naming `where`
double parse_number(std::string_view text, const std::string& file, const std::string& where);
/// \param degrees vertical. \throws InvalidInput naming `where`
Camera make_camera(double width, double height, double degrees, const std::string& file,
                   const std::string& where);
/// Degrees without the rounding error of a conversion to radians and back: "60".
std::string degrees_text(Radians angle);

/// \throws InvalidInput "differing-size" if an array has another size or type than the first,
/// which is `info`
void check_same_size(std::size_t views, std::size_t dimensions, DType type, const FeatureInfo& info,
                     const std::string& file, const std::string& where);

/// Copies stored numbers of `type` to floats. False if one of them is not finite.
bool copy_numbers(const std::byte* from, DType type, std::span<float> out) noexcept;
/// The bytes of numbers as `type` stores them. \param halves memory for them
std::span<const std::byte> stored_bytes(std::span<const float> numbers, DType type,
                                        std::vector<std::uint16_t>& halves);

}  // namespace enfilade::features::formats
