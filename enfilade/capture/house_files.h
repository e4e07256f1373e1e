/// \file  A mesh's rooms, objects and segments as Matterport3D's `house_segmentations` have them.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/geometry/rect.h"
#include "enfilade/mesh/house.h"
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

}  // namespace enfilade::capture
