/// \file  Writes a lit mesh as a scan on disk, in Matterport3D's files.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/geometry/rect.h"
#include "enfilade/mesh/house.h"
#include "enfilade/mesh/lighting.h"
#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/segmentation.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::capture {

/// A room of a building, to be a region of its files.
struct ScanRoom {
  char type = 'z';           ///< Matterport3D's region letter
  Rect floor;                ///< metres, world
  double floor_z = 0;        ///< world
  double height = 2.6;       ///< above the floor
  std::uint32_t storey = 0;  ///< level in files
};

/// Content of the four files.
struct HouseFiles {
  mesh::House house;                       ///< `<scan>.house`
  mesh::LabelledMesh labels;               ///< `<scan>.ply`
  std::vector<std::int32_t> segments;      ///< `<scan>.fsegs.json`: of each triangle
  std::vector<mesh::SegmentGroup> groups;  ///< `<scan>.semseg.json`
};

/// Makes the four files.
/// - Regions are rooms, in their order; without rooms, one of type 'z' around everything.
/// - Objects are the mesh's, in its order, each in the region that it names, its box along the
///   axes. Classes are those of mpcat40.
/// - Segments are connected pieces of objects (and of surfaces without an object), numbered as the
///   triangles first meet them.
/// - Panoramas are the included viewpoints, each in the region below it, with the 18 images of
///   scan::rig_cameras().
/// - Vertices have the mean colour of the surfaces around them.
///
/// \param image_width of those images, pixels
/// \pre check(mesh) has no errors
/// \throws ArgumentError for an object whose category is not in mpcat40
/// \throws InvalidInput as scan::poses_of()
HouseFiles make_house_files(const mesh::Mesh& mesh, const scan::Connectivity& connectivity,
                            const std::vector<ScanRoom>& rooms, std::uint32_t image_width = 1280);

/// The files that are written for a scan, below `<root>/v1/scans/<scan>/`.
struct ScanParts {
  bool faces = false;         ///< matterport_skybox_images: six colour JPEGs a viewpoint
  bool colour_strip = false;  ///< there: all six side by side
  bool depth_strip = false;   ///< there: ray-exact distances
  bool label_strips = false;  ///< there: classes and instances
  /// undistorted_{color,depth}_images (18 of each a viewpoint), undistorted_camera_parameters,
  /// matterport_camera_{poses,intrinsics}
  bool undistorted = false;
  bool house = false;  ///< house_segmentations: .house, .ply, .fsegs.json, .semseg.json, ...
  bool mesh = false;   ///< `matterport_mesh/<hash>/<hash>.{obj,glb}` with textures
  /// `<root>/connectivity`: the graph and its line in scans.txt. Off where `root` has them already.
  bool connectivity = true;

  /// Whether anything is written below v1/scans.
  bool any() const noexcept {
    return faces || colour_strip || depth_strip || label_strips || undistorted || house || mesh;
  }
  /// Whether any picture is in colour. If not, the mesh needs no light.
  bool coloured() const noexcept { return faces || colour_strip || undistorted; }
};

/// The parts' names for users: "skybox", "strips" (colour, depth, classes, instances), "depth",
/// "labels", "undistorted", "house", "mesh", "all".
std::vector<std::string> scan_part_names();
/// The parts of those names. \throws ArgumentError for another name
ScanParts scan_parts(const std::vector<std::string>& names);

/// Which files are written, and how finely.
struct ScanFilesOptions {
  ScanParts parts;
  std::uint32_t face_size = 512;     ///< texels
  std::uint32_t image_width = 1280;  ///< of undistorted images, pixels; heights are 4/5 of it
  std::uint32_t samples = 4;         ///< colour rays per pixel: 1, 4, 9 or 16
  float exposure = 0;                ///< stops
  int jpeg_quality = 92;             ///< 1 .. 100; with full chroma from 90 on
  std::vector<ScanRoom> rooms;       ///< for the .house file.
  /// Mesh with the classes and instances of the label strips, if they are of another mesh of the
  /// same building (mesh::read_house_mesh()); null: the mesh's own.
  const mesh::LitMesh* label_mesh = nullptr;
  int threads = 0;  ///< 0: all cores; never changes a byte
};

/// The result of write_scan().
struct ScanFilesReport {
  std::filesystem::path folder;       ///< `<root>/v1/scans/<scan>`
  std::size_t viewpoints = 0;         ///< included ones, which have pictures
  std::size_t written = 0, kept = 0;  ///< pictures; kept: there from a run that was stopped
  std::uintmax_t bytes = 0;           ///< of the written files
};

/// Baking options that take hardly any time, for a mesh of which no colour is wanted.
mesh::BakeOptions least_light();

/// The labelled mesh of a scan's `house_segmentations`, for ScanFilesOptions::label_mesh. Pictures
/// of one mesh of a building get the classes and instances of another.
/// \param warnings  as of mesh::read_house_mesh()
/// \throws as mesh::read_house_mesh()
std::unique_ptr<const mesh::LitMesh> read_label_mesh(
    const std::filesystem::path& house_segmentations, const std::string& scan,
    std::vector<Diagnostic>* warnings = nullptr);

/// Writes `<root>/connectivity/<scan>_connectivity.json` and its line in scans.txt, and the parts.
/// Then `root` is a data set that scan::DataRoot and scan::open_matterport_images() open. Each file
/// is written whole or not at all.
///
/// Existing pictures of the same mesh, lights, viewpoint and options are kept (baking options are
/// not compared). So a killed run can be continued, and parts and viewpoints may be added later;
/// `enfilade_scan.json` records that. The time for pictures is proportional to their pixels. They
/// are rendered in parallel, one per thread.
/// \throws ArgumentError for options out of range or a scan id that cannot be part of a file name
/// \throws FileError if existing files were made from other inputs, naming one, or cannot be
/// written
/// \throws InvalidInput as scan::poses_of()
ScanFilesReport write_scan(const mesh::LitMesh& mesh, const scan::Connectivity& connectivity,
                           const std::filesystem::path& root, const ScanFilesOptions& options,
                           const Progress& progress = {});

}  // namespace enfilade::capture
