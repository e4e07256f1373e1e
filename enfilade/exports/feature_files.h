/// \file  Features in the HDF5 files that HAMT, DUET and their descendants read.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "enfilade/exports/options.h"
#include "enfilade/features/hdf5_writer.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::exports {

/// Source of the numbers, and their type.
struct FeatureSource {
  std::filesystem::path features;  ///< of views: any file that features::FeatureSet opens.
  /// An encoder's classes of the same viewpoints, which become the last columns; pretraining of
  /// HAMT and DUET reads them. Empty: none.
  std::filesystem::path logits = {};
  /// kFloat16, kFloat32 or kFloat64. The published files have kFloat64; readers take each.
  features::Hdf5Type type = features::Hdf5Type::kFloat32;
};

/// A dataset "<scan>_<viewpoint>" of (36, columns) per included viewpoint, packed by gzip. Its
/// attributes are `scanId`, `viewpointId`, `image_w`, `image_h` (pixels) and `vfov` (degrees).
/// Continues a stopped run. `options.progress` counts viewpoints.
/// \throws LookupError if viewpoints have no features, naming one; ArgumentError for another type
/// \throws as features::FeatureSet::open(); FileError
void write_view_features(const std::shared_ptr<const graph::GraphSet>& graphs,
                         const FeatureSource& source, const std::filesystem::path& file,
                         const ExportOptions& options = {});

/// As many objects of a viewpoint as REVERIE's models take.
inline constexpr std::size_t kMostObjects = 20;

/// REVERIE's file of objects: a dataset (n, columns) per viewpoint that sees some, the first `most`
/// in the order of the boxes; none for others. Attributes, beside those of write_view_features():
/// - `directions` (n, 2): heading and elevation of the box's middle, radians, world
/// - `sizes` (n, 2): its width and height, pixels of 640 x 480
/// - `bboxes` (n, 4): x, y, width, height, pixels of 640 x 480
/// - `viewindexs` (n): its view
/// - `obj_ids` (n): texts
///
/// The box is an object's largest. Its features are the mean of those of the (at most three) views
/// with its largest boxes. They are those of whole views, not of pictures cut to the box. Continues
/// a stopped run.
/// \throws as write_view_features()
void write_object_features(const std::shared_ptr<const graph::GraphSet>& graphs,
                           const tasks::ObjectBoxes& boxes, const FeatureSource& source,
                           const std::filesystem::path& file, std::size_t most = kMostObjects,
                           const ExportOptions& options = {});

/// Shapes that arrays of a viewpoint's tokens may have.
struct TokenShape {
  std::vector<std::int64_t> views;  ///< any of these
  std::int64_t tokens = 0;          ///< per view
};
/// BEVBert's `vit_b16_224_clip_patch.hdf5`: of the 12 level views (viewIndex 12 to 23), 224 x 224
/// pixels of 90 degrees, 14 x 14 tokens in rows.
TokenShape bevbert_tokens();
/// GridMM's `clip_p32.hdf5`: of the 36 views, or the 12 level ones, a class token and 7 x 7.
TokenShape gridmm_tokens();

/// A dataset (views, tokens, columns) of 16 bit floats per included viewpoint, without attributes.
/// It comes from a file of weights (features::TensorFile: safetensors, PyTorch) with arrays
/// "<scan>_<viewpoint>" of such a shape. Continues a stopped run.
/// \throws as write_view_features(); InvalidInput for other shapes
void write_tokens(const std::shared_ptr<const graph::GraphSet>& graphs,
                  const std::filesystem::path& tokens, const TokenShape& shape,
                  const std::filesystem::path& file, const ExportOptions& options = {});

}  // namespace enfilade::exports
