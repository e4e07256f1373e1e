/// \file  Views of every viewpoint: JPEG files, as MapGPT and others open them; depth and classes
/// in the HDF5 files that GridMM and BEVBert read.
#pragma once
#include <cstddef>
#include <filesystem>

#include "enfilade/dataset/dataset.h"
#include "enfilade/exports/options.h"
#include "enfilade/geometry/camera.h"

namespace enfilade::exports {

/// Camera and quality of the pictures.
struct ViewPicturesOptions {
  Camera camera = {};  ///< 640 x 480 pixels, 60 degrees: MapGPT's own
  int quality = 92;    ///< of JPEG, 1 to 100
};

/// How much was done.
struct ViewPicturesReport {
  std::size_t viewpoints = 0;  ///< with all 36 pictures
  std::size_t kept = 0;        ///< of them, those that an earlier run had written
};

/// Writes `<folder>/<scan>/<viewpoint>/<view>.jpg` of each included viewpoint; view 0 to 35 is
/// MatterSim's viewIndex. A viewpoint's folder appears when all its pictures are there; a stopped
/// run is continued. `enfilade_views.txt` in `folder` has the pictures' source. `options.progress`
/// counts viewpoints.
/// \throws ArgumentError for a camera or quality out of range, or a viewpoint whose id cannot be a
/// file's name
/// \throws LookupError for panoramas without colour
/// \throws FileError, also if the folder has pictures of another camera or data set; InvalidInput
ViewPicturesReport write_view_pictures(const dataset::Dataset& data,
                                       const std::filesystem::path& folder,
                                       const ViewPicturesOptions& pictures = {},
                                       const ExportOptions& options = {});

// A dataset "<scan>_<viewpoint>" per included viewpoint, packed by gzip, with the attributes of
// write_view_features(). Pictures are rendered from the data set's panoramas, which need the layer.
// A stopped run is continued. `options.progress` counts viewpoints. All throw LookupError for
// panoramas without the layer, and FileError, InvalidInput for broken files.

/// GridMM's `depth.hdf5`: (36, 128, 128) uint16, views of 128 x 128 pixels and 60 degrees; quarter
/// millimetres along the optical axis (its readers divide by 4000), 0 where there is no reading.
void write_gridmm_depth(const dataset::Dataset& data, const std::filesystem::path& file,
                        const ExportOptions& options = {});

/// Metres that BEVBert's depths have as 1: its readers multiply by 10. Farther depths are 1, too.
inline constexpr float kBevbertMetres = 10;

/// BEVBert's `depth_14x14.hdf5`: (12, 14, 14) 32 bit floats of the 12 level views (viewIndex 12 to
/// 23) of 224 x 224 pixels and 90 degrees. Each is the mean of a cell of 16 x 16 pixels, along the
/// optical axis, in units of kBevbertMetres; 0 without readings.
void write_bevbert_depth(const dataset::Dataset& data, const std::filesystem::path& file,
                         const ExportOptions& options = {});

/// BEVBert's `semantic41_14x14.hdf5`: (12, 14, 14) uint8, the class of mpcat40 in the middle of
/// each cell of the same views. Void, misc and unlabelled are 0.
void write_bevbert_classes(const dataset::Dataset& data, const std::filesystem::path& file,
                           const ExportOptions& options = {});

}  // namespace enfilade::exports
