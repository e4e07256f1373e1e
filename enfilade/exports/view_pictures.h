/// \file  The 36 views of every viewpoint as JPEG files, as MapGPT and others open them.
#pragma once
#include <cstddef>
#include <filesystem>

#include "enfilade/dataset/dataset.h"
#include "enfilade/exports/options.h"
#include "enfilade/geometry/camera.h"

namespace enfilade::exports {

/// What the pictures are like.
struct ViewPicturesOptions {
  Camera camera = {};  ///< 640 x 480 pixels, 60 degrees: MapGPT's own
  int quality = 92;    ///< of JPEG, 1 to 100
};

/// How much was done.
struct ViewPicturesReport {
  std::size_t viewpoints = 0;  ///< whose 36 pictures are there now
  std::size_t kept = 0;        ///< of them, those that an earlier run had written
};

/// Writes `<folder>/<scan>/<viewpoint>/<view>.jpg`, view 0 to 35 being MatterSim's viewIndex, of
/// each included viewpoint. A viewpoint's folder appears when all its pictures are there; a run
/// that was stopped goes on. `enfilade_views.txt` in `folder` says of what the pictures are.
/// `options.progress` counts viewpoints. \throws ArgumentError for a camera or quality out of
/// range, or a viewpoint whose id is no name of a file; LookupError for panoramas without colour;
/// FileError, also if the folder has pictures of another camera or data set; InvalidInput
ViewPicturesReport write_view_pictures(const dataset::Dataset& data,
                                       const std::filesystem::path& folder,
                                       const ViewPicturesOptions& pictures = {},
                                       const ExportOptions& options = {});

}  // namespace enfilade::exports
