/// \file  Reader and writer of Matterport3D's `.house` files: levels, regions, panoramas and
/// objects.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/geometry/vec.h"

namespace enfilade::mesh {

/// An axis-aligned box.
struct HouseBox {
  Vec3d low, high;
};
/// A storey (record L).
struct HouseLevel {
  std::string label;  ///< empty in files: "-"
  Vec3d position;
  HouseBox box;
};
/// A room (record R).
struct HouseRegion {
  std::int32_t level = -1;
  char label = '-';  ///< room type: 'b' bedroom, 'k' kitchen, ...
  Vec3d position;
  HouseBox box;
  double height = 0;  ///< metres from the floor polygon; <= 0: to the house's top
};
/// A passage between two rooms (record P).
struct HousePortal {
  std::int32_t region0 = -1, region1 = -1;
  std::string label;
  Vec3d p0, p1;
};
/// A surface of a room (record S), whose outline is its vertices.
struct HouseSurface {
  std::int32_t region = -1;
  char label = 'F';
  Vec3d position, normal;
  HouseBox box;
};
/// A corner of a surface (record V).
struct HouseVertex {
  std::int32_t surface = -1;
  std::string label;
  Vec3d position, normal;
};
/// A panorama: a viewpoint (record P of ASCII 1.1).
struct HousePanorama {
  std::string name;  ///< viewpoint id
  std::int32_t region = -1;
  Vec3d position;
};
/// One picture of a panorama with its camera (record I).
struct HouseImage {
  std::int32_t panorama = -1;
  std::string name;
  std::int32_t camera = 0, yaw = 0;
  std::array<double, 16> camera_from_world{};  ///< row-major; the camera looks along -z, y up
  std::array<double, 9> intrinsics{};
  std::uint32_t width = 0, height = 0;
  Vec3d position;
};
/// A category of objects (record C).
struct HouseCategory {
  std::int32_t mapping_index = 0;  ///< row of category_mapping.tsv
  std::string mapping_name;
  std::int32_t mpcat40_index = 0;
  std::string mpcat40_name;
};
/// An object (record O).
struct HouseObject {
  std::int32_t region = -1, category = -1;  ///< -1: none
  Vec3d position, axis0, axis1, radii;      ///< an oriented box; axis2 = axis0 x axis1
};
/// A segment of the mesh that belongs to an object (record E).
struct HouseSegment {
  std::int32_t object = -1;
  std::int32_t id = 0;  ///< of the segmentation's faces
  double area = 0;
  Vec3d position;
  HouseBox box;
};

/// A whole file. An entry's index in its list is its index in the file.
struct House {
  std::string name, label;
  HouseBox box;
  std::vector<HouseLevel> levels;
  std::vector<HouseRegion> regions;
  std::vector<HousePortal> portals;
  std::vector<HouseSurface> surfaces;
  std::vector<HouseVertex> vertices;
  std::vector<HousePanorama> panoramas;
  std::vector<HouseImage> images;
  std::vector<HouseCategory> categories;
  std::vector<HouseObject> objects;
  std::vector<HouseSegment> segments;
};

/// Parses a file. \param file its name in messages
/// \throws InvalidInput naming line and field of each fault:
/// - a first line other than `ASCII 1.x`, or a record of the wrong length
/// - an invalid number, a wrong index, or another number of records than in the H line
House parse_house(std::string_view text, const std::string& file);
/// The file's content, which parse_house() reads back equal. Spaces in names become '#'.
std::string to_text(const House& house);

}  // namespace enfilade::mesh
