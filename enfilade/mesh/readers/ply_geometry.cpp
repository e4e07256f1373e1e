#include <fmt/format.h>
#include <array>
#include <cmath>
#include <utility>

#include "enfilade/image/tone.h"
#include "enfilade/mesh/readers/ply.h"
#include "enfilade/mesh/readers/reader.h"
#include "enfilade/mesh/readers/text.h"

namespace enfilade::mesh::readers {
namespace ply {
namespace {

/// Three columns of single numbers that belong together.
struct Triple {
  const Column *x = nullptr, *y = nullptr, *z = nullptr;
  explicit operator bool() const { return x != nullptr && y != nullptr && z != nullptr; }
  Vec3f at(std::size_t row) const {
    return {static_cast<float>(x->values[row]), static_cast<float>(y->values[row]),
            static_cast<float>(z->values[row])};
  }
};

const Column* single(const Element& element, std::initializer_list<std::string_view> names) {
  const Column* column = element.find(names);
  return column != nullptr && !column->list ? column : nullptr;
}

/// The value that stands for 1: of whole numbers the largest of their type; int holds bytes here.
double most(Type type) {
  switch (type) {
    case Type::kFloat:
    case Type::kDouble:
      return 1;
    case Type::kUint16:
      return 65535;
    default:
      return 255;
  }
}

void read_colours(const Element& vertices, Mesh& mesh) {
  const Triple colour{single(vertices, {"red", "diffuse_red"}),
                      single(vertices, {"green", "diffuse_green"}),
                      single(vertices, {"blue", "diffuse_blue"})};
  if (!colour) return;
  const auto linear = [](const Column& column, std::size_t row) {
    const double share = column.values[row] / most(column.type);
    // Not std::clamp: not a number has to stay one, for check() to find.
    return image::linear_from_srgb(static_cast<float>(share < 0 ? 0 : share > 1 ? 1 : share));
  };
  mesh.colours.reserve(vertices.rows);
  for (std::size_t i = 0; i < vertices.rows; ++i) {
    mesh.colours.push_back({linear(*colour.x, i), linear(*colour.y, i), linear(*colour.z, i)});
  }
  mesh.materials[0].colour = {1, 1, 1};
}

/// All normals or none: a normal of length 0 means that the writer did not know them.
std::vector<Vec3f> read_normals(const Element& vertices) {
  const Triple normal{single(vertices, {"nx"}), single(vertices, {"ny"}), single(vertices, {"nz"})};
  std::vector<Vec3f> out;
  if (!normal) return out;
  out.reserve(vertices.rows);
  for (std::size_t i = 0; i < vertices.rows; ++i) {
    const Vec3f n = normal.at(i);
    const float size = length(n);
    if (!std::isfinite(size) || size == 0) return {};
    out.push_back({n.x / size, n.y / size, n.z / size});
  }
  return out;
}

void read_faces(const Element& faces, const Column& corners, const std::string& file,
                Geometry& out) {
  FaultList faults(file);
  const std::size_t positions = out.mesh.positions.size();
  std::vector<std::uint32_t> polygon;
  std::size_t begin = 0;
  for (std::size_t f = 0; f < faces.rows; ++f) {
    polygon.clear();
    for (std::size_t i = begin; i < corners.ends[f]; ++i) {
      const double value = corners.values[i];
      if (!(value >= 0) || value >= static_cast<double>(positions) || value != std::floor(value)) {
        faults.error(fmt::format("face {}", f), "bad-index",
                     fmt::format("vertex {}, not one of the {} there are", value, positions));
        break;
      }
      polygon.push_back(static_cast<std::uint32_t>(value));
    }
    begin = corners.ends[f];
    if (polygon.size() < 3) ++out.short_faces;
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      out.mesh.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
      out.face.push_back(static_cast<std::uint32_t>(f));
    }
  }
  faults.throw_if_any();
}

}  // namespace

std::span<const std::string_view> geometry_properties() {
  static constexpr std::array<std::string_view, 14> kNames{"x",
                                                           "y",
                                                           "z",
                                                           "nx",
                                                           "ny",
                                                           "nz",
                                                           "red",
                                                           "green",
                                                           "blue",
                                                           "diffuse_red",
                                                           "diffuse_green",
                                                           "diffuse_blue",
                                                           "vertex_indices",
                                                           "vertex_index"};
  return kNames;
}

Geometry geometry(const File& ply, const std::string& file) {
  const Element* vertices = ply.find("vertex");
  const Element* faces = ply.find("face");
  if (vertices == nullptr) refuse(file, "", "missing-element", "no element \"vertex\"");
  if (faces == nullptr) refuse(file, "", "no-triangles", "no element \"face\": a cloud of points?");
  const Triple position{single(*vertices, {"x"}), single(*vertices, {"y"}),
                        single(*vertices, {"z"})};
  if (!position) refuse(file, "element vertex", "missing-property", "no x, y and z");
  const Column* corners = faces->find({"vertex_indices", "vertex_index"});
  if (corners == nullptr || !corners->list) {
    refuse(file, "element face", "missing-property", "no list vertex_indices or vertex_index");
  }
  Geometry out;
  out.mesh.materials.resize(1);
  out.mesh.positions.reserve(vertices->rows);
  for (std::size_t i = 0; i < vertices->rows; ++i) out.mesh.positions.push_back(position.at(i));
  read_colours(*vertices, out.mesh);
  read_faces(*faces, *corners, file, out);
  out.mesh.triangle_material.assign(out.mesh.triangles.size(), 0);
  const std::vector<Vec3f> normals = read_normals(*vertices);
  if (!normals.empty()) {
    out.mesh.normals.reserve(out.mesh.triangles.size());
    for (const auto& t : out.mesh.triangles) {
      out.mesh.normals.push_back({normals[t[0]], normals[t[1]], normals[t[2]]});
    }
  }
  return out;
}

}  // namespace ply

ReadResult read_ply(const Source& source) {
  const ply::File file = ply::parse(source.bytes, source.name, ply::geometry_properties());
  ply::Geometry geometry = ply::geometry(file, source.name);
  ReadResult out;
  out.mesh = std::move(geometry.mesh);
  for (const ply::Element& element : file.elements) {
    if (element.name == "vertex" || element.name == "face" || element.rows == 0) continue;
    warn(out, source.name, "element " + element.name, "left-out",
         fmt::format("{} rows are not read: only vertex and face are", element.rows));
  }
  if (geometry.short_faces > 0) {
    warn(out, source.name, "element face", "left-out",
         fmt::format("{} faces of fewer than 3 corners", geometry.short_faces));
  }
  return out;
}

}  // namespace enfilade::mesh::readers
