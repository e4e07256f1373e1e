/// \file  Imports a user's panoramas as a scan in Matterport3DSimulator's files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/progress.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::capture {

/// The pictures of one viewpoint: JPEG, PNG or Radiance HDR.
struct PanoramaFiles {
  std::string viewpoint;  ///< its id, valid by scan::is_scan_id().
  /// One equirectangular picture, or six square faces by index(CubeFace). The up and down faces are
  /// those of turning up or down from the front.
  std::vector<std::string> files;
};

/// Which viewpoints are connected, besides ImportOptions::pairs.
enum class ImportEdges : std::uint8_t {
  kNone,
  kLine,  ///< each imported viewpoint to the one before it in the graph
  kNear,  ///< each imported viewpoint to all within ImportOptions::reach
};

/// Largest ImportOptions::face_size.
inline constexpr std::uint32_t kLargestImportedFace = 8192;
/// Distance between viewpoints with unknown positions, metres: the mean length of an edge in R2R's
/// graphs.
inline constexpr double kImportSpacing = 2.25;

/// How panoramas are imported.
struct ImportOptions {
  std::uint32_t face_size = 0;  ///< texels; 0: by the picture's resolution, at most 1024
  /// Exposure of HDR pictures, stops; no value: the median luminance becomes mid-grey.
  std::optional<double> exposure;
  /// Direction of the pictures' middles (of front faces), degrees clockwise from north. Without
  /// this and a heading in `positions`, new viewpoints have the picture's own (GPano) or 0.
  std::optional<double> heading;
  /// File with a line `name x y z [heading]` per viewpoint: the eye's position in metres (x east, y
  /// north, z up), the heading in degrees. The name may be the picture's, with folder and suffix.
  /// - Values are separated by blanks, tabs or commas, or by semicolons.
  /// - Between tabs or semicolons, numbers may have decimal commas. Quotes are ignored.
  /// - `#` begins a comment. A first line without numbers is a header.
  ///
  /// Empty: new viewpoints stand in a line, kImportSpacing apart.
  std::filesystem::path positions;
  double eye_height = 1.5;  ///< above the floor, metres
  ImportEdges edges = ImportEdges::kLine;
  double reach = 5;                                        ///< of ImportEdges::kNear, metres
  std::vector<std::pair<std::string, std::string>> pairs;  ///< viewpoints to connect
  bool force = false;                                      ///< replace viewpoints that are there
  /// Apply GPano's pitch, roll and heading. False for pictures that were levelled after the camera
  /// wrote these fields.
  bool use_pose = true;
};

/// One panorama as it was written.
struct ImportedPanorama {
  std::string viewpoint;
  std::uint32_t face_size = 0;
  Vec3d position;  ///< metres, world frame
};
/// The imported panoramas, and the size of the scan afterwards.
struct ImportReport {
  std::vector<ImportedPanorama> panoramas;  ///< in the order given
  std::size_t added = 0;                    ///< how many of them are new to the scan
  std::size_t viewpoints = 0, edges = 0;    ///< of the scan after the import
  /// Warnings and notes:
  /// - an orientation or a pose that was applied
  /// - parts of a sphere that are missing
  /// - harmless oddities of a file
  /// - ids with "_"
  std::vector<Diagnostic> findings;
};

/// Adds panoramas to a scan, or begins one. Writes
/// `<folder>/<scan>/matterport_skybox_images/<viewpoint>_skybox_small.jpg`,
/// `<folder>/connectivity/<scan>_connectivity.json` and the scan's line in `scans.txt`. Existing
/// edges stay. Pictures are turned by EXIF's orientation. Spheres are levelled by GPano's pitch and
/// roll. Cropped ones are black where they have no picture. All pictures and `scans.txt` are read
/// before the first file is written, so that a broken one leaves the scan unchanged.
/// \throws ArgumentError or LookupError for invalid or repeated ids, or ids in the scan already
/// (unless `force`)
/// \throws ArgumentError or LookupError for pairs that do not name two viewpoints of the scan, and
/// viewpoints that `positions` lacks
/// \throws FileError
/// \throws InvalidInput for pictures, positions, a graph or a `scans.txt` that cannot be used
ImportReport import_panoramas(const std::filesystem::path& folder, const std::string& scan,
                              std::span<const PanoramaFiles> panoramas,
                              const ImportOptions& options, const Progress& progress = {});

}  // namespace enfilade::capture
