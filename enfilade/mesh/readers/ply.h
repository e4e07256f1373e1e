/// \file  PLY (Stanford's polygon files): tables of numbers and lists.
#pragma once
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh::readers::ply {

enum class PropertyType : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat,
  kDouble
};

/// The values of one property. Doubles hold all types exactly.
struct Column {
  std::string name;
  PropertyType type = PropertyType::kFloat;
  bool list = false;
  PropertyType count_type = PropertyType::kUint8;
  std::vector<double> values;     ///< empty if the property was not wanted
  std::vector<std::size_t> ends;  ///< of lists: row r's values end before ends[r]
};
struct Element {
  std::string name;
  std::size_t rows = 0;
  std::vector<Column> columns;
  /// The first property of one of these names, or null.
  const Column* find(std::initializer_list<std::string_view> names) const;
};
struct File {
  std::vector<Element> elements;
  std::vector<std::string> textures;  ///< of the header's `comment TextureFile` lines
  OddValues unknown_lines;            ///< of the header: unknown, or with more words than they need
  OddValues long_rows;                ///< rows of more values than properties
  OddValues odd_values;               ///< words that are no numbers, corners excepted
  const Element* find(std::string_view name) const;
};

/// ASCII and binary of either byte order; keeps properties whose names are `wanted`. Values that
/// are no finite numbers are NaN. Memory is bounded by a multiple of the file's size.
/// \throws InvalidInput
File parse(std::string_view bytes, const std::string& file,
           std::span<const std::string_view> wanted);

/// Names that geometry() reads.
std::span<const std::string_view> geometry_properties();
/// Positions, colours (sRGB in files), normals, texture points, and polygons as fans.
struct Geometry {
  Mesh mesh;                        ///< a material per texture, at least one; no pictures yet
  std::vector<std::uint32_t> face;  ///< the file's face that each triangle was part of
  std::size_t short_faces = 0;      ///< faces of fewer than three corners: left out
  OddValues positions, normals, colours, texture_points;  ///< not finite, by rows of the element
  OddValues texture_numbers;                              ///< faces of a texture that is missing
  float largest_colour = 0;  ///< of float and double; see colour_divisor()
};
/// \throws InvalidInput for elements or properties that are missing, bad indices, and faces whose
/// positions are not finite
Geometry geometry(const File& ply, const std::string& file);
/// Warns of the odd values of both, by counts.
void tell_odd_values(const File& ply, const Geometry& geometry, const std::string& file,
                     ReadResult& out);

}  // namespace enfilade::mesh::readers::ply
