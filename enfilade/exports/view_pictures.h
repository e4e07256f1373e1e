/// \file  The 36 views of every viewpoint as JPEG files, as MapGPT and others open them.
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

}  // namespace enfilade::exports
