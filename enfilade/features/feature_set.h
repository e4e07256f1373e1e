/// \file  Feature files: an image encoder's output for the 36 views of every viewpoint.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/geometry/camera.h"

namespace enfilade::features {

/// File formats of features. docs/features.md has the layout of each.
enum class FeatureFormat {
  kSafetensors,  ///< per viewpoint an array "<scan>_<viewpoint>" (views, dimensions); mapped
  kTsv,          ///< rows in base64, as published with R2R
  kHdf5,         ///< per viewpoint a dataset "<scan>_<viewpoint>", as in HAMT and DUET
};
/// The format by the suffix: .safetensors, .tsv, .h5 / .hdf5. \throws ArgumentError for others
FeatureFormat format_of(const std::filesystem::path& file);

/// Properties of all features of a set.
struct FeatureInfo {
  std::string encoder;           ///< "resnet152", "home"; empty if not in the file
  std::string preprocessing;     ///< "caffe", "torchvision", "home"; likewise
  std::string weights;           ///< hash of the encoder's weights, 16 hex digits; likewise
  std::size_t views = 36;        ///< per viewpoint: rows of an array
  std::size_t dimensions = 0;    ///< per view: columns; 2048 for ResNet-152
  Camera camera;                 ///< of the views
  DType type = DType::kFloat32;  ///< as stored: kFloat32 or kFloat16
};

/// A viewpoint by its names.
struct FeatureKey {
  std::string scan;
  std::string viewpoint;
  friend bool operator==(const FeatureKey&, const FeatureKey&) = default;
};

/// Features read from a file. Immutable: any thread may read. safetensors are mapped, other formats
/// are read into memory.
class FeatureSet {
 public:
  /// \throws FileError
  /// \throws InvalidInput naming the viewpoint: sizes that differ, a repeated viewpoint, invalid
  /// ids (core/names.h), broken base64. In formats that are read into memory, also for numbers that
  /// are not finite
  static FeatureSet open(const std::filesystem::path& file);

  const FeatureInfo& info() const noexcept;
  std::span<const FeatureKey> keys() const noexcept;  ///< the viewpoint of each row
  /// The row of a viewpoint, if the set has it.
  std::optional<std::size_t> row(std::string_view scan, std::string_view viewpoint) const;

  /// Copies one view of a viewpoint. \pre row < keys().size(), view < info().views, out.size() ==
  /// info().dimensions \throws InvalidInput naming the viewpoint, for a number that is not finite
  void copy_view(std::size_t row, std::size_t view, std::span<float> out) const;
  /// Copies all views of a viewpoint, (views, dimensions). \pre out.size() fits \throws as
  /// copy_view()
  void copy_views(std::size_t row, std::span<float> out) const;

  /// The first `n` numbers of each view; the data is shared. \throws ArgumentError unless n is from
  /// 1 to info().dimensions
  FeatureSet first_columns(std::size_t n) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

/// For an agent with `dimensions` numbers per view. If the set has 1,000 more, returns the first
/// ones: features are published with the scores of ImageNet's classes after them. Else returns the
/// set itself.
FeatureSet without_class_scores(const FeatureSet& features, std::size_t dimensions);

/// Writes features, one viewpoint at a time, in any order. The file has its name only after
/// finish(); until then the data is in "<file>.part". In safetensors the rows written survive if
/// the process is killed; rows lost in a power failure are detected and written again. One thread.
class FeatureWriter {
 public:
  /// Continues a "<file>.part" of the same info and keys (safetensors; other formats begin again).
  /// \throws FileError, also if another process is writing it
  /// \throws ArgumentError for no keys, equal `<scan>_<viewpoint>`, names with control characters
  /// or "/", 0 dimensions, or types other than kFloat32 and kFloat16
  /// \throws ArgumentError for a layout that the format does not support: TSV has 36 views of
  /// kFloat32
  static FeatureWriter create(const std::filesystem::path& file, const FeatureInfo& info,
                              std::vector<FeatureKey> keys);
  ~FeatureWriter();
  FeatureWriter(FeatureWriter&&) noexcept;
  FeatureWriter& operator=(FeatureWriter&&) noexcept;

  bool written(std::size_t row) const;  ///< by this run, or by an earlier one that was stopped
  std::size_t rows_left() const noexcept;
  /// \param views (info.views, info.dimensions) \throws FileError; ArgumentError for another size
  /// or a number that is not finite, or too large for info.type. \pre not finished
  void write(std::size_t row, std::span<const float> views);
  /// \throws FileError; ArgumentError while rows_left() > 0
  void finish();

 private:
  FeatureWriter();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Merges sets into one file, e.g. the shards of a cluster, or converts one to another format or
/// type. Rows are in the order of the files. \throws InvalidInput if their infos differ (types may)
/// or a viewpoint comes twice; as FeatureSet::open() and FeatureWriter
void convert_features(std::span<const std::filesystem::path> from, const std::filesystem::path& to,
                      DType type = DType::kFloat32);

}  // namespace enfilade::features
