#include "enfilade/mesh/semantic_ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/mesh/readers/ply.h"
#include "enfilade/mesh/readers/reader.h"

namespace enfilade::mesh {

using namespace readers;

namespace {

constexpr std::string_view kObjectId = "object_id";
constexpr double kMostId = 65535;

// Negative ids are taken as unsigned ones of their type.
std::uint32_t id_of(double value, ply::PropertyType type, std::uint32_t face,
                    const std::string& file) {
  if (!(value <= kMostId) || value != std::floor(value) || value < INT32_MIN) {
    refuse(file, fmt::format("face {}", face), "bad-value",
           fmt::format("{} {}, not a whole number up to {}", kObjectId, value, kMostId));
  }
  const std::uint32_t bits = type == ply::PropertyType::kInt8 ? 0xFFU : 0xFFFFU;
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(value)) & bits;
}

std::vector<std::uint32_t> ids_of(const ply::Element& faces, const ply::Geometry& geometry,
                                  const std::string& file) {
  const ply::Column* const column = faces.find({kObjectId});
  if (column == nullptr || column->list || column->type == ply::PropertyType::kFloat ||
      column->type == ply::PropertyType::kDouble) {
    refuse(file, "element face", "missing-property",
           fmt::format("no property {} of whole numbers", kObjectId));
  }
  std::vector<std::uint32_t> out;
  out.reserve(geometry.face.size());
  for (const std::uint32_t face : geometry.face) {
    out.push_back(id_of(column->values[face], column->type, face, file));
  }
  return out;
}

}  // namespace

Mesh parse_semantic_ply(std::string_view bytes, const std::string& file) {
  const auto geometry_names = ply::geometry_properties();
  std::vector<std::string_view> wanted(geometry_names.begin(), geometry_names.end());
  wanted.push_back(kObjectId);
  const ply::File parsed = ply::parse(bytes, file, wanted);
  ply::Geometry geometry = ply::geometry(parsed, file);
  const std::vector<std::uint32_t> ids = ids_of(*parsed.find("face"), geometry, file);
  if (geometry.mesh.colours.empty()) {
    refuse(file, "element vertex", "missing-property",
           "no red, green and blue, which Habitat-Sim requires");
  }
  Mesh out;
  out.positions = std::move(geometry.mesh.positions);
  out.triangles = std::move(geometry.mesh.triangles);
  out.triangle_material.resize(out.triangles.size());
  out.materials.resize(1);
  out.triangle_object.reserve(ids.size());
  for (const std::uint32_t id : ids) out.triangle_object.push_back(id == 0 ? kNoObject : id - 1);
  out.objects.resize(ids.empty() ? 0 : *std::ranges::max_element(ids));
  auto found = check(out, file);
  if (count(found, Severity::kError) > 0) throw InvalidInput(std::move(found));
  return out;
}

}  // namespace enfilade::mesh
