/// \file  What an image encoder says of the 36 views of every viewpoint, in files.
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

/// Files that features are kept in. docs/features.md has each one's layout.
enum class FeatureFormat {
  kSafetensors,  ///< ours: an array "<scan>_<viewpoint>" (views, dimensions) a viewpoint; mapped
  kTsv,          ///< base64 rows, as the authors of R2R published theirs
  kHdf5,         ///< a dataset "<scan>_<viewpoint>" a viewpoint, as HAMT's and DUET's
};
/// By suffix: .safetensors, .tsv, .h5 / .hdf5. \throws ArgumentError naming those
FeatureFormat format_of(const std::filesystem::path& file);

/// What is true of a whole set.
struct FeatureInfo {
  std::string encoder;           ///< "resnet152", "home"; empty where a file does not say
  std::string preprocessing;     ///< "caffe", "torchvision", "home"; likewise
  std::string weights;           ///< of what the encoder was loaded from: 16 hex digits of a hash
  std::size_t views = 36;        ///< rows an array
  std::size_t dimensions = 0;    ///< columns, 2048 for ResNet-152
  Camera camera;                 ///< that the views were seen through
  DType type = DType::kFloat32;  ///< as stored: kFloat32 or kFloat16
};

/// Which viewpoint a row of features is of.
struct FeatureKey {
  std::string scan;
  std::string viewpoint;
  friend bool operator==(const FeatureKey&, const FeatureKey&) = default;
};

/// Features to read. Immutable: any thread. safetensors are mapped, other formats read into memory.
class FeatureSet {
 public:
  /// \throws FileError; InvalidInput naming the viewpoint: sizes that differ, a viewpoint that
  /// comes twice, broken base64; of formats that are read into memory, numbers that are not finite,
  /// too
  static FeatureSet open(const std::filesystem::path& file);

  const FeatureInfo& info() const noexcept;
  std::span<const FeatureKey> keys() const noexcept;  ///< row -> viewpoint
  /// The row of a viewpoint; no value if the file has none of it.
  std::optional<std::size_t> row(std::string_view scan, std::string_view viewpoint) const;

  /// One view of a viewpoint. \pre row < keys().size(), view < info().views, out.size() ==
  /// info().dimensions \throws InvalidInput naming the viewpoint, for a number that is not finite
  void copy_view(std::size_t row, std::size_t view, std::span<float> out) const;
  /// All of a viewpoint, (views, dimensions). \pre out.size() fits \throws as copy_view()
  void copy_views(std::size_t row, std::span<float> out) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

/// Features to write, a viewpoint at a time in any order. The file is there under its own name only
/// when finish() has returned; until then "<file>.part" holds what was written. Of safetensors,
/// what was written outlives a kill at any moment, and a power cut is noticed. One thread.
class FeatureWriter {
 public:
  /// Goes on with a "<file>.part" made for the same info and keys (safetensors only; others start
  /// again). \throws FileError, also if another process is writing it; ArgumentError for no key,
  /// equal keys, names with control characters or "/", viewpoints with "_", 0 dimensions, other
  /// types than kFloat32 and kFloat16, and what the format does not have: TSV has 36 views of
  /// kFloat32
  static FeatureWriter create(const std::filesystem::path& file, const FeatureInfo& info,
                              std::vector<FeatureKey> keys);
  ~FeatureWriter();
  FeatureWriter(FeatureWriter&&) noexcept;
  FeatureWriter& operator=(FeatureWriter&&) noexcept;

  bool written(std::size_t row) const;  ///< also by an earlier run that was stopped
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

/// Puts sets together into one file, e.g. the shards of a cluster; or changes the format of one.
/// The order of rows is that of the files. `from` may be of other types than `type`. \throws
/// InvalidInput if infos (but for the type) differ or a viewpoint comes twice; as open() and
/// FeatureWriter
void convert_features(std::span<const std::filesystem::path> from, const std::filesystem::path& to,
                      DType type = DType::kFloat32);

}  // namespace enfilade::features
