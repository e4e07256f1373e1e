/// \file  Matterport3D's `house_segmentations`: the object of each triangle of a building.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// `<scan>.ply` of a segmentation: a mesh with three numbers for each face.
struct LabelledMesh {
  Mesh mesh;  ///< with vertex colours and one material, without objects
  std::vector<std::int32_t> face_segment;   ///< per triangle; -1: none (also in the next two)
  std::vector<std::int32_t> face_object;    ///< "material" in files: index of the object in .house
  std::vector<std::int32_t> face_category;  ///< row of category_mapping.tsv, as files have it
  std::vector<std::uint32_t> face;  ///< index of the face in the file that each triangle is part of
  std::size_t faces = 0;            ///< number of faces in the file
  std::vector<Diagnostic> warnings;  ///< odd values, as read_mesh() has them
};
/// Property names as shipped (`material_id`, `segment_id`, `category_id`) or as documented
/// (`face_material`, ...).
/// \throws InvalidInput for a broken file, a missing property, and values that are not whole
/// numbers of 32 bits
LabelledMesh parse_labelled_ply(std::string_view bytes, const std::string& file);
/// Binary, little-endian, without normals; each triangle becomes a face. \pre the three lists of
/// numbers have one for each triangle
std::string to_labelled_ply(const LabelledMesh& mesh);

/// `.fsegs.json`: the segment of each face, a whole number from -1 (none) on, or a string that
/// holds one. \throws InvalidInput
std::vector<std::int32_t> parse_face_segments(std::string_view json, const std::string& file);
std::string face_segments_json(const std::vector<std::int32_t>& segments, const std::string& scan);

/// An object of `.semseg.json`: its raw label and segments.
struct SegmentGroup {
  std::int32_t id = -1;  ///< -1: the file has none
  std::string label;
  std::vector<std::int32_t> segments;
};
/// \throws InvalidInput
std::vector<SegmentGroup> parse_segment_groups(std::string_view json, const std::string& file);
std::string segment_groups_json(const std::vector<SegmentGroup>& groups, const std::string& scan);

/// A scan's mesh with its objects, from SCAN.house, SCAN.ply, SCAN.fsegs.json and SCAN.semseg.json
/// of a folder.
/// - triangle -> segment: fsegs, of the face that it is part of
/// - segment -> object: the .house's E records; else semseg
/// - object -> category: O and C records; mpcat40
///
/// Names of objects are semseg's labels, else the category's. Objects are those of the .house in
/// its order, then those that only semseg has. A category that mpcat40 does not have becomes void.
/// \param warnings  of the .ply are added to it; null: dropped
/// \throws FileError; InvalidInput, also if the files disagree (faces, segments in two objects)
Mesh read_house_mesh(const std::filesystem::path& folder, const std::string& scan,
                     std::vector<Diagnostic>* warnings = nullptr);

}  // namespace enfilade::mesh
