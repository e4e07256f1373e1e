#include "enfilade/mesh/segmentation.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/detail/json.h"
#include "enfilade/core/gzip.h"
#include "enfilade/image/tone.h"
#include "enfilade/mesh/house.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/mesh/readers/ply.h"
#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh {

using namespace readers;

namespace {

using json::Element;
using json::Faults;
using json::Path;

constexpr std::array<std::string_view, 2> kObjectNames{"material_id", "face_material"};
constexpr std::array<std::string_view, 2> kSegmentNames{"segment_id", "face_segment"};
constexpr std::array<std::string_view, 2> kCategoryNames{"category_id", "face_category"};

/// A whole number of each triangle's face.
std::vector<std::int32_t> face_numbers(const ply::Element& faces, const ply::Geometry& geometry,
                                       const std::array<std::string_view, 2>& names,
                                       const std::string& file) {
  const ply::Column* column = faces.find({names[0], names[1]});
  if (column == nullptr || column->list) {
    refuse(file, "element face", "missing-property",
           fmt::format("no {} or {}", names[0], names[1]));
  }
  std::vector<std::int32_t> out;
  out.reserve(geometry.face.size());
  for (const std::uint32_t face : geometry.face) {
    const double value = column->values[face];
    if (!(value >= std::numeric_limits<std::int32_t>::min() &&
          value <= std::numeric_limits<std::int32_t>::max()) ||
        value != std::floor(value)) {
      refuse(file, fmt::format("face {}", face), "bad-value",
             fmt::format("{} {}, not a whole number of 32 bits", column->name, value));
    }
    out.push_back(static_cast<std::int32_t>(value));
  }
  return out;
}

/// Appends a number's bytes, the least first.
template <class T>
void put(std::string& out, T value) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::ranges::reverse(raw);
  out.append(raw.data(), raw.size());
}

/// A number, or a text that is one.
std::optional<std::int32_t> whole(Element element, const Path& path, Faults& faults) {
  constexpr std::int64_t kLeast = -1, kMost = std::numeric_limits<std::int32_t>::max();
  std::optional<std::int64_t> value;
  std::string_view text;
  if (element.get(text) == simdjson::SUCCESS) {
    value = to_integer(text);
  } else if (element.is_int64()) {
    value = element.get_int64().value_unsafe();
  }
  if (value && *value >= kLeast && *value <= kMost) return static_cast<std::int32_t>(*value);
  faults.error(path, "bad-value",
               fmt::format("{}, not a whole number from -1 on", json::describe(element)));
  return std::nullopt;
}

std::vector<std::int32_t> whole_numbers(Element element, const Path& path, Faults& faults) {
  std::vector<std::int32_t> out;
  const auto list = json::array(element, path, faults);
  if (!list) return out;
  out.reserve(list->size());
  constexpr std::size_t kMostFaults = 100;
  std::size_t i = 0;
  for (const Element item : *list) {
    const auto value = whole(item, Path(path, i++), faults);
    if (value) out.push_back(*value);
    if (faults.errors() >= kMostFaults) break;
  }
  return out;
}

SegmentGroup read_group(Element element, const Path& path, Faults& faults) {
  constexpr std::array<json::Field, 5> kFields{{{"segments", true},
                                                {"label", false},
                                                {"label_index", false},
                                                {"id", false},
                                                {"objectId", false}}};
  std::array<std::optional<Element>, 5> found;
  SegmentGroup out;
  if (!json::fields(element, kFields, found, path, faults)) return out;
  out.segments = whole_numbers(*found[0], Path(path, "segments"), faults);
  if (found[1] && !found[1]->is_null()) {
    if (const auto label = json::string(*found[1], Path(path, "label"), faults)) out.label = *label;
  }
  for (const std::size_t k : {std::size_t{3}, std::size_t{4}}) {
    if (!found[k] || found[k]->is_null()) continue;
    out.id = whole(*found[k], Path(path, kFields[k].name), faults).value_or(-1);
    break;
  }
  return out;
}

/// Calls `read` for the one field of a file's object. \throws InvalidInput
template <class Read>
void read_field(std::string_view text, const std::string& file, std::string_view name,
                const Read& read) {
  const json::Document document = json::Document::parse(text, file);
  Faults faults(file);
  const Path root;
  if (const auto found = json::field(document.root(), {name}, root, faults)) {
    read(*found, Path(root, name), faults);
  }
  faults.throw_if_errors();
}

std::string json_text(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

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

LabelledMesh parse_labelled_ply(std::string_view bytes, const std::string& file) {
  std::vector<std::string_view> wanted;
  for (const std::string_view name : ply::geometry_properties()) wanted.push_back(name);
  for (const auto& names : {kObjectNames, kSegmentNames, kCategoryNames}) {
    wanted.insert(wanted.end(), names.begin(), names.end());
  }
  const ply::File parsed = ply::parse(bytes, file, wanted);
  ply::Geometry geometry = ply::geometry(parsed, file);
  const ply::Element& faces = *parsed.find("face");
  LabelledMesh out;
  ReadResult told;
  ply::tell_odd_values(parsed, geometry, file, told);
  out.warnings = std::move(told.warnings);
  out.face_segment = face_numbers(faces, geometry, kSegmentNames, file);
  out.face_object = face_numbers(faces, geometry, kObjectNames, file);
  out.face_category = face_numbers(faces, geometry, kCategoryNames, file);
  out.mesh = std::move(geometry.mesh);
  out.mesh.normals.clear();
  out.mesh.texture_points.clear();  // its classes need no pictures
  out.mesh.materials.resize(1);
  std::ranges::fill(out.mesh.triangle_material, 0U);
  out.face = std::move(geometry.face);
  out.faces = faces.rows;
  auto found = check(out.mesh, file);
  if (count(found, Severity::kError) > 0) throw InvalidInput(std::move(found));
  return out;
}

std::string to_labelled_ply(const LabelledMesh& labelled) {
  const Mesh& mesh = labelled.mesh;
  EN_CHECK_EQ(labelled.face_segment.size(), mesh.triangles.size());
  EN_CHECK_EQ(labelled.face_object.size(), mesh.triangles.size());
  EN_CHECK_EQ(labelled.face_category.size(), mesh.triangles.size());
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nelement face {}\nproperty list uchar int vertex_indices\n"
      "property int material_id\nproperty int segment_id\nproperty int category_id\nend_header\n",
      mesh.positions.size(), mesh.triangles.size());
  out.reserve(out.size() + 15 * mesh.positions.size() + 25 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3f p = mesh.positions[i];
    const Vec3f c = mesh.colours.empty() ? Vec3f{1, 1, 1} : mesh.colours[i];
    put(out, p.x);
    put(out, p.y);
    put(out, p.z);
    for (const float share : {c.x, c.y, c.z}) put(out, image::srgb8_from_linear(share));
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    put(out, std::uint8_t{3});
    for (const std::uint32_t corner : mesh.triangles[t]) put(out, corner);
    put(out, labelled.face_object[t]);
    put(out, labelled.face_segment[t]);
    put(out, labelled.face_category[t]);
  }
  return out;
}

std::vector<std::int32_t> parse_face_segments(std::string_view text, const std::string& file) {
  std::vector<std::int32_t> out;
  read_field(text, file, "segIndices", [&](Element list, const Path& path, Faults& faults) {
    out = whole_numbers(list, path, faults);
  });
  return out;
}

std::string face_segments_json(const std::vector<std::int32_t>& segments, const std::string& scan) {
  return fmt::format("{{\"sceneId\":{},\"segIndices\":[{}]}}\n", json_text(scan),
                     fmt::join(segments, ","));
}

std::vector<SegmentGroup> parse_segment_groups(std::string_view text, const std::string& file) {
  std::vector<SegmentGroup> out;
  read_field(text, file, "segGroups", [&](Element list, const Path& path, Faults& faults) {
    const auto groups = json::array(list, path, faults);
    if (!groups) return;
    for (const Element group : *groups) {
      out.push_back(read_group(group, Path(path, out.size()), faults));
    }
  });
  return out;
}

std::string segment_groups_json(const std::vector<SegmentGroup>& groups, const std::string& scan) {
  std::string out = fmt::format("{{\"sceneId\":{},\"segGroups\":[", json_text(scan));
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const SegmentGroup& group = groups[i];
    out += fmt::format("{}\n{{\"id\":{},\"objectId\":{},\"label\":{},\"segments\":[{}]}}",
                       i == 0 ? "" : ",", group.id, group.id, json_text(group.label),
                       fmt::join(group.segments, ","));
  }
  return out + "]}\n";
}

Mesh read_house_mesh(const std::filesystem::path& folder, const std::string& scan,
                     std::vector<Diagnostic>* warnings) {
  const auto path = [&](const char* ending) { return find_text_file(folder / (scan + ending)); };
  const auto house_file = path(".house"), ply_file = path(".ply"), faces_file = path(".fsegs.json"),
             groups_file = path(".semseg.json");
  const House house = parse_house(read_text_file(house_file), house_file.string());
  LabelledMesh labelled = parse_labelled_ply(read_text_file(ply_file), ply_file.string());
  if (warnings != nullptr) {
    warnings->insert(warnings->end(), labelled.warnings.begin(), labelled.warnings.end());
  }
  const auto segments = parse_face_segments(read_text_file(faces_file), faces_file.string());
  const auto groups = parse_segment_groups(read_text_file(groups_file), groups_file.string());
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
