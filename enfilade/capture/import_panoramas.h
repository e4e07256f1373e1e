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

#include "enfilade/core/progress.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::capture {

/// The pictures of one viewpoint: JPEG, PNG or Radiance HDR.
struct PanoramaFiles {
  std::string viewpoint;  ///< its id, of the characters that scan::is_scan_id() allows
  /// One equirectangular picture, or six square faces by index(CubeFace), up and down as seen by
  /// turning up or down from the front.
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
/// Distance between viewpoints whose positions are not known, metres: the mean length of an edge in
/// R2R's graphs.
inline constexpr double kImportSpacing = 2.25;

/// How panoramas are imported.
struct ImportOptions {
  std::uint32_t face_size = 0;     ///< texels; 0: the picture's resolution, at most 1024
  std::optional<double> exposure;  ///< of HDR pictures, stops; none: the median becomes mid-grey
  /// Heading of the pictures' middles (front faces), degrees clockwise from north; 0 if neither
  /// this nor `positions` says.
  std::optional<double> heading;
  /// File of lines `name x y z [heading]`, blanks or commas between: the eye in metres (x east,
  /// y north, z up), and degrees. `#` begins a comment; a first line that begins with "name" is a
  /// table's head. Empty: new viewpoints stand in a line, kImportSpacing apart.
  std::filesystem::path positions;
  double eye_height = 1.5;  ///< above the floor, metres
  ImportEdges edges = ImportEdges::kLine;
  double reach = 5;                                        ///< of ImportEdges::kNear, metres
  std::vector<std::pair<std::string, std::string>> pairs;  ///< viewpoints to connect
  bool force = false;                                      ///< replace viewpoints that are there
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
  std::size_t added = 0;                    ///< of them, new to the scan
  std::size_t viewpoints = 0, edges = 0;    ///< of the scan now
};

/// Adds panoramas to a scan, or begins one. Writes
/// `<folder>/<scan>/matterport_skybox_images/<viewpoint>_skybox_small.jpg`,
/// `<folder>/connectivity/<scan>_connectivity.json` and the scan's line in `scans.txt`. Edges that
/// are there stay. All pictures are read before the first file is written, so that a broken one
/// leaves the scan as it was.
/// \throws ArgumentError or LookupError for ids that are none, repeated or there already (unless
/// `force`), pairs that name no two viewpoints, viewpoints without a position; FileError;
/// InvalidInput for pictures and positions that cannot be used
ImportReport import_panoramas(const std::filesystem::path& folder, const std::string& scan,
                              std::span<const PanoramaFiles> panoramas,
                              const ImportOptions& options, const Progress& progress = {});

}  // namespace enfilade::capture
