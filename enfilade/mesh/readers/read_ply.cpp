// What a mesh has of a PLY file.

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "enfilade/image/tone.h"
#include "enfilade/mesh/readers/ply.h"

namespace enfilade::mesh::readers {
namespace ply {
namespace {

/// Three columns of single numbers that belong together.
struct Triple {
  const Column *x = nullptr, *y = nullptr, *z = nullptr;
  explicit operator bool() const { return x != nullptr && y != nullptr && z != nullptr; }
  Vec3f at(std::size_t row) const {
    return {to_float_or_nan(x->values[row]), to_float_or_nan(y->values[row]),
            to_float_or_nan(z->values[row])};
  }
};

const Column* single(const Element& element, std::initializer_list<std::string_view> names) {
  const Column* column = element.find(names);
  return column != nullptr && !column->list ? column : nullptr;
}
const Column* list(const Element& element, std::initializer_list<std::string_view> names) {
  const Column* column = element.find(names);
  return column != nullptr && column->list ? column : nullptr;
}

bool is_float(PropertyType type) {
  return type == PropertyType::kFloat || type == PropertyType::kDouble;
}
/// The value that stands for 1: of whole numbers the largest of their type; int holds bytes here,
/// as floats do if one of them is too large for a share of one.
double most(PropertyType type, float largest) {
  switch (type) {
    case PropertyType::kFloat:
    case PropertyType::kDouble:
      return colour_divisor(largest);
    case PropertyType::kUint16:
      return 65535;
    default:
      return 255;
  }
}

std::string row_of(const char* element, std::size_t row) {
  return fmt::format("{} {}", element, row);
}

void read_colours(const Element& vertices, Geometry& out) {
  const Triple colour{single(vertices, {"red", "diffuse_red"}),
                      single(vertices, {"green", "diffuse_green"}),
                      single(vertices, {"blue", "diffuse_blue"})};
  if (!colour) return;
  for (const Column* column : {colour.x, colour.y, colour.z}) {
    if (!is_float(column->type)) continue;
    for (const double value : column->values) {
      const float v = to_float_or_nan(value);
      if (v > out.largest_colour) out.largest_colour = v;  // NaN is not
    }
  }
  const auto linear = [&](const Column& column, std::size_t row) {
    const double share = column.values[row] / most(column.type, out.largest_colour);
    return image::linear_from_srgb(static_cast<float>(std::clamp(share, 0.0, 1.0)));
  };
  out.mesh.colours.reserve(vertices.rows);
  for (std::size_t i = 0; i < vertices.rows; ++i) {
    Vec3f value{1, 1, 1};
    if (is_finite(colour.at(i))) {
      value = {linear(*colour.x, i), linear(*colour.y, i), linear(*colour.z, i)};
    } else {
      out.colours.add([&] { return row_of("vertex", i); });
    }
    out.mesh.colours.push_back(value);
  }
  for (Material& material : out.mesh.materials) material.colour = {1, 1, 1};
}

/// Normals of length 1; 0 where the writer did not know one. Empty if it knew none.
std::vector<Vec3f> read_normals(const Element& vertices, Geometry& geometry) {
  const Triple normal{single(vertices, {"nx"}), single(vertices, {"ny"}), single(vertices, {"nz"})};
  std::vector<Vec3f> out;
  if (!normal) return out;
  out.reserve(vertices.rows);
  bool any = false;
  for (std::size_t i = 0; i < vertices.rows; ++i) {
    const Vec3f n = normal.at(i);
    const double size = length(to_double(n));
    if (!std::isfinite(size)) geometry.normals.add([&] { return row_of("vertex", i); });
    const bool known = std::isfinite(size) && size > 0;
    any = any || known;
    out.push_back(known ? to_float({n.x / size, n.y / size, n.z / size}) : Vec3f{});
  }
  if (!any) out.clear();
  return out;
}

/// Where texture points are: of each corner of a face (MeshLab's), or of each vertex (Blender's).
struct TexturePlaces {
  const Column* corners = nullptr;  ///< u, v of each corner
  const Column *u = nullptr, *v = nullptr;
  const Column* number = nullptr;  ///< the face's texture

  TexturePlaces(const Element& vertices, const Element& faces)
      : corners(list(faces, {"texcoord"})),
        u(single(vertices, {"s", "u", "texture_u"})),
        v(single(vertices, {"t", "v", "texture_v"})),
        number(single(faces, {"texnumber"})) {
    if (u == nullptr || v == nullptr) u = v = nullptr;
  }
  bool any() const { return corners != nullptr || u != nullptr; }
};

/// Reads the faces in order.
class FaceReader {
 public:
  FaceReader(const Element& vertices, const Element& faces, const Column& corners,
             const std::string& file, Geometry& out)
      : faces_(faces), corners_(corners), places_(vertices, faces), faults_(file), out_(out) {}

  void read() {
    std::size_t begin = 0, first_point = 0;
    for (face_ = 0; face_ < faces_.rows; ++face_) {
      const std::size_t end = corners_.ends[face_];
      const bool good = read_polygon(begin, end);
      read_points(first_point);
      begin = end;
      if (!good) continue;
      if (polygon_.size() < 3) ++out_.short_faces;
      add_triangles();
    }
    faults_.throw_if_any();
  }

 private:
  bool read_polygon(std::size_t begin, std::size_t end) {
    polygon_.clear();
    const std::vector<Vec3f>& positions = out_.mesh.positions;
    for (std::size_t i = begin; i < end; ++i) {
      const double value = corners_.values[i];
      const bool there =
          value >= 0 && value < static_cast<double>(positions.size()) && value == std::floor(value);
      if (!there) {
        fault("bad-index",
              fmt::format("vertex {}, not one of the {} there are", value, positions.size()));
        return false;
      }
      const auto place = static_cast<std::uint32_t>(value);
      if (!is_finite(positions[place])) {
        fault("not-finite", fmt::format("vertex {}, whose position is not finite", place));
        return false;
      }
      polygon_.push_back(place);
    }
    return true;
  }
  void fault(const char* code, std::string message) {
    faults_.error(row_of("face", face_), code, std::move(message));
  }

  /// The texture points of the polygon's corners. \param first of the face's values; moved on
  void read_points(std::size_t& first) {
    points_.assign(polygon_.size(), {});
    std::size_t end = first;
    if (places_.corners != nullptr) end = places_.corners->ends[face_];
    bool good = true;
    for (std::size_t k = 0; k < polygon_.size(); ++k) {
      float u = 0, v = 0;
      if (first + 2 * k + 1 < end) {
        u = to_float_or_nan(places_.corners->values[first + 2 * k]);
        v = to_float_or_nan(places_.corners->values[first + 2 * k + 1]);
      } else if (places_.u != nullptr) {
        u = to_float_or_nan(places_.u->values[polygon_[k]]);
        v = to_float_or_nan(places_.v->values[polygon_[k]]);
      }
      good = good && std::isfinite(u) && std::isfinite(v);
      points_[k] = {std::isfinite(u) ? u : 0, 1 - (std::isfinite(v) ? v : 0)};  // v goes up
    }
    if (!good) out_.texture_points.add([&] { return row_of("face", face_); });
    first = end;
  }
  std::uint32_t material() {
    if (places_.number == nullptr) return 0;
    const double number = places_.number->values[face_];
    const auto count = static_cast<double>(out_.mesh.materials.size());
    if (number >= 0 && number < count) return static_cast<std::uint32_t>(number);
    // MeshLab writes -1 for a face without a texture; without pictures, the number says nothing.
    if (count > 1 && number != -1) {
      out_.texture_numbers.add([&] { return row_of("face", face_); });
    }
    return 0;
  }
  void add_triangles() {
    const std::uint32_t material_of_face = polygon_.size() < 3 ? 0 : material();
    for (std::size_t k = 2; k < polygon_.size(); ++k) {
      out_.mesh.triangles.push_back({polygon_[0], polygon_[k - 1], polygon_[k]});
      out_.mesh.triangle_material.push_back(material_of_face);
      if (places_.any()) {
        out_.mesh.texture_points.push_back({points_[0], points_[k - 1], points_[k]});
      }
      out_.face.push_back(static_cast<std::uint32_t>(face_));
    }
  }

  const Element& faces_;
  const Column& corners_;
  TexturePlaces places_;
  FaultList faults_;
  Geometry& out_;
  std::size_t face_ = 0;
  std::vector<std::uint32_t> polygon_;
  std::vector<TexturePoint> points_;
};

/// Those of the vertices, or the triangle's own.
void set_normals(const std::vector<Vec3f>& normals, Mesh& mesh) {
  if (normals.empty()) return;
  mesh.normals.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    std::array<Vec3f, 3> corners{normals[t[0]], normals[t[1]], normals[t[2]]};
    for (Vec3f& normal : corners) {
      if (normal == Vec3f{}) normal = face_normal(mesh, i);
    }
    mesh.normals.push_back(corners);
  }
}

}  // namespace

std::span<const std::string_view> geometry_properties() {
  static constexpr auto kNames = std::to_array<std::string_view>({"x",
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
                                                                  "vertex_index",
                                                                  "texcoord",
                                                                  "texnumber",
                                                                  "s",
                                                                  "t",
                                                                  "u",
                                                                  "v",
                                                                  "texture_u",
                                                                  "texture_v"});
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
  const Column* corners = list(*faces, {"vertex_indices", "vertex_index"});
  if (corners == nullptr) {
    refuse(file, "element face", "missing-property", "no list vertex_indices or vertex_index");
  }
  Geometry out;
  out.mesh.materials.resize(std::max<std::size_t>(ply.textures.size(), 1));
  out.mesh.positions.reserve(vertices->rows);
  for (std::size_t i = 0; i < vertices->rows; ++i) out.mesh.positions.push_back(position.at(i));
  read_colours(*vertices, out);
  const std::vector<Vec3f> normals = read_normals(*vertices, out);
  FaceReader(*vertices, *faces, *corners, file, out).read();
  set_normals(normals, out.mesh);
  for (std::size_t i = 0; i < out.mesh.positions.size(); ++i) {
    if (is_finite(out.mesh.positions[i])) continue;
    out.positions.add([&] { return row_of("vertex", i); });
    out.mesh.positions[i] = {};  // no face uses it
  }
  return out;
}

namespace {

/// Reads the pictures that `comment TextureFile` names.
void read_textures(const File& ply, const Source& source, ReadResult& out) {
  if (ply.textures.empty() || out.mesh.texture_points.empty()) {
    if (!ply.textures.empty()) {
      warn(
          out, source.name, "", "left-out",
          fmt::format("texture {}: no texture coordinates are there", quote(ply.textures.front())));
    } else if (!out.mesh.texture_points.empty()) {
      warn(out, source.name, "", "left-out",
           "texture coordinates: no line \"comment TextureFile NAME\" names their picture");
      out.mesh.texture_points.clear();
    }
    return;
  }
  TextureDecoder decoder;
  for (std::size_t k = 0; k < ply.textures.size(); ++k) {
    const std::string& name = ply.textures[k];
    Material& material = out.mesh.materials[k];
    material.name = name;
    try {
      const Source::Part part = source.find(name);
      material.texture = decoder.decode(read_part(part.path), part.path.string(), out);
      material.texture_file = part.path.string();
      material.colour = {1, 1, 1};
      note_moved(out, source.name, "", name, part);
    } catch (const Error& e) {
      warn(out, source.name, "", "missing-texture", e.what());
    }
  }
}

}  // namespace

void tell_odd_values(const File& ply, const Geometry& geometry, const std::string& file,
                     ReadResult& out) {
  warn(out, file, ply.unknown_lines, "unknown-line",
       "lines of the header are free text, or have more words than they need");
  warn(out, file, ply.long_rows, "long-row", "rows have more values than the header says");
  warn(out, file, ply.odd_values, "bad-value",
       "values are no numbers, but the shape does not need them");
  warn(out, file, geometry.positions, "not-finite",
       "positions are not finite numbers; no face uses them");
  warn(out, file, geometry.normals, "not-finite",
       "normals are not finite numbers: those of the faces are taken");
  warn(out, file, geometry.colours, "not-finite", "colours are not finite numbers: taken as white");
  note_colour_bytes(out, file, geometry.largest_colour);
  warn(out, file, geometry.texture_points, "not-finite",
       "faces have texture coordinates that are not finite numbers: taken as 0");
  warn(out, file, geometry.texture_numbers, "bad-index",
       "faces name a texture that is missing: the first is taken");
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
  ply::tell_odd_values(file, geometry, source.name, out);
  ply::read_textures(file, source, out);
  return out;
}

}  // namespace enfilade::mesh::readers
