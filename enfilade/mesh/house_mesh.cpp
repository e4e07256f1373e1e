#include <fmt/format.h>
#include <algorithm>
#include <unordered_map>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/mesh/house.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/mesh/readers/text.h"
#include "enfilade/mesh/segmentation.h"

namespace enfilade::mesh {

using namespace readers;

namespace {

/// The object of each segment.
using SegmentObjects = std::unordered_map<std::int32_t, std::uint32_t>;

/// Reports a segment that is of another object already.
void add_segment(SegmentObjects& objects, std::int32_t segment, std::uint32_t object,
                 const std::string& where, FaultList& faults) {
  const auto [at, fresh] = objects.emplace(segment, object);
  if (fresh || at->second == object) return;
  faults.error(
      where, "repeated-segment",
      fmt::format("segment {} is of object {}, but of {} before", segment, object, at->second));
}

std::uint32_t find_object(const SegmentObjects& objects, std::int32_t segment) {
  const auto at = objects.find(segment);
  return at == objects.end() ? kNoObject : at->second;
}

Object object_of(const House& house, const HouseObject& from) {
  Object out;
  out.region = from.region;
  if (from.category < 0) return out;
  const HouseCategory& category = house.categories[static_cast<std::size_t>(from.category)];
  out.name = category.mapping_name.empty() ? category.mpcat40_name : category.mapping_name;
  if (category.mpcat40_index >= 0 && category.mpcat40_index < std::int32_t{kMpcat40Size}) {
    out.category = static_cast<std::uint16_t>(category.mpcat40_index);
  }
  return out;
}

/// An object that only the .semseg.json knows: its category is that of the label elsewhere.
Object object_of(const House& house, const SegmentGroup& group) {
  Object out;
  const auto at = std::ranges::find(house.categories, group.label, &HouseCategory::mapping_name);
  if (at != house.categories.end()) {
    HouseObject like;
    like.category = static_cast<std::int32_t>(at - house.categories.begin());
    out = object_of(house, like);
  }
  out.name = group.label;
  return out;
}

SegmentObjects house_objects(const House& house, const std::string& file, Mesh& mesh) {
  for (const HouseObject& object : house.objects) mesh.objects.push_back(object_of(house, object));
  SegmentObjects out;
  FaultList faults(file);
  for (std::size_t i = 0; i < house.segments.size(); ++i) {
    const HouseSegment& segment = house.segments[i];
    if (segment.object < 0) continue;
    add_segment(out, segment.id, static_cast<std::uint32_t>(segment.object), fmt::format("E {}", i),
                faults);
  }
  faults.throw_if_any();
  return out;
}

/// Names the house's objects, and adds those that it does not have.
void add_groups(const std::vector<SegmentGroup>& groups, const House& house,
                const std::string& file, SegmentObjects& objects, Mesh& mesh) {
  FaultList faults(file);
  SegmentObjects group_of;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const SegmentGroup& group = groups[g];
    const std::string where = fmt::format("$.segGroups[{}]", g);
    std::uint32_t added = kNoObject;
    for (const std::int32_t segment : group.segments) {
      add_segment(group_of, segment, static_cast<std::uint32_t>(g), where, faults);
      const std::uint32_t object = find_object(objects, segment);
      if (object != kNoObject) {
        if (object != added && !group.label.empty()) mesh.objects[object].name = group.label;
        continue;
      }
      if (added == kNoObject) {
        added = static_cast<std::uint32_t>(mesh.objects.size());
        mesh.objects.push_back(object_of(house, group));
      }
      add_segment(objects, segment, added, where, faults);
    }
  }
  faults.throw_if_any();
}

}  // namespace

Mesh read_house_mesh(const std::filesystem::path& folder, const std::string& scan) {
  const auto path = [&](const char* ending) { return folder / (scan + ending); };
  const auto house_file = path(".house"), ply_file = path(".ply"), faces_file = path(".fsegs.json"),
             groups_file = path(".semseg.json");
  const House house = parse_house(read_file(house_file), house_file.string());
  LabelledMesh labelled = parse_labelled_ply(read_file(ply_file), ply_file.string());
  const auto segments = parse_face_segments(read_file(faces_file), faces_file.string());
  const auto groups = parse_segment_groups(read_file(groups_file), groups_file.string());
  if (segments.size() != labelled.faces) {
    refuse(faces_file.string(), "$.segIndices", "bad-count",
           fmt::format("segments of {} faces, but {} has {}", segments.size(), ply_file.string(),
                       labelled.faces));
  }
  Mesh mesh = std::move(labelled.mesh);
  SegmentObjects objects = house_objects(house, house_file.string(), mesh);
  add_groups(groups, house, groups_file.string(), objects, mesh);
  mesh.triangle_object.reserve(mesh.triangles.size());
  for (const std::uint32_t face : labelled.face) {
    mesh.triangle_object.push_back(find_object(objects, segments[face]));
  }
  return mesh;
}

}  // namespace enfilade::mesh
