#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <numeric>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/tone.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/mesh/read_mesh.h"

namespace enfilade::mesh {
namespace {

/// Places of all triangles, by object (those of none first), then by material.
std::vector<std::size_t> by_object_and_material(const Mesh& mesh) {
  std::vector<std::size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // kNoObject + 1 is 0.
  std::ranges::stable_sort(order, {}, [&](std::size_t t) {
    return std::pair(object_of(mesh, t) + 1, mesh.triangle_material[t]);
  });
  return order;
}

/// A texture as a file: PNG if it has cut-outs, else JPEG.
struct EncodedTexture {
  std::vector<std::uint8_t> bytes;
  std::string_view suffix;  ///< "png" or "jpg"
};
EncodedTexture encode_texture(const image::Image8& texture) {
  constexpr int kQuality = 92;  // above it files grow faster than differences shrink
  if (texture.channels == 4) return {image::encode_png(texture), "png"};
  return {image::encode_jpeg(texture, kQuality), "jpg"};
}

// --- binary glTF
// ------------------------------------------------------------------------------------

static_assert(std::endian::native == std::endian::little, "GLB is little-endian");

using Json = nlohmann::ordered_json;

// Numbers of the glTF 2.0 specification.
constexpr int kFloat = 5126, kUnsignedInt = 5125, kArrayBuffer = 34962, kElementBuffer = 34963,
              kRepeat = 10497, kLinear = 9729, kLinearMipmapLinear = 9987;

/// glTF has +y up: (x, y, z) there is (x, z, -y) of ours.
std::array<float, 3> y_up(Vec3f v) { return {v.x, v.z, -v.y}; }

/// One of the file's arrays: a buffer view that many accessors share.
class Array {
 public:
  Array(const char* type, std::size_t width, int component, int target)
      : type_(type), width_(width), component_(component), target_(target) {}

  void add(std::span<const float> values) { append(values.data(), values.size_bytes()); }
  void add(std::uint32_t value) { append(&value, sizeof value); }

  /// The accessor of what was added since the last call; adds it to `accessors`.
  Json& accessor(Json& accessors, std::size_t view) {
    const std::size_t size = 4 * width_;
    accessors.push_back({{"bufferView", view},
                         {"byteOffset", begin_},
                         {"componentType", component_},
                         {"count", (bytes_.size() - begin_) / size},
                         {"type", type_}});
    begin_ = bytes_.size();
    return accessors.back();
  }
  Json view(std::size_t offset) const {
    Json json{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes_.size()}};
    if (target_ == kArrayBuffer) json["byteStride"] = 4 * width_;
    json["target"] = target_;
    return json;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void append(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }

  const char* type_;
  std::size_t width_;
  int component_, target_;
  std::size_t begin_ = 0;
  std::string bytes_;
};

class GlbWriter {
 public:
  GlbWriter(const Mesh& mesh, UpAxis up) : mesh_(mesh), z_up_(up == UpAxis::kZ) {}

  std::string write() {
    json_["asset"] = {{"version", "2.0"}, {"generator", "Enfilade"}};
    json_["scene"] = 0;
    json_["scenes"] = Json::array({{{"nodes", Json::array()}}});
    for (const char* name : {"nodes", "meshes", "materials", "accessors"}) {
      json_[name] = Json::array();
    }
    add_triangles();
    Json views = Json::array();
    std::string buffer;
    for (const Array* array : {&positions_, &normals_, &texture_points_, &colours_, &indices_}) {
      if (array->bytes().empty()) continue;
      views.push_back(array->view(buffer.size()));
      buffer += array->bytes();
    }
    add_materials(views, buffer);
    json_["bufferViews"] = std::move(views);
    json_["buffers"] = Json::array({{{"byteLength", buffer.size()}}});
    return container(std::move(buffer));
  }

 private:
  std::array<float, 3> in_file(Vec3f v) const {
    return z_up_ ? std::array{v.x, v.y, v.z} : y_up(v);
  }

  /// A node an object, with a primitive for each of its materials.
  void add_triangles() {
    std::uint32_t object = 0, material = 0;
    bool first = true;
    for (const std::size_t t : by_object_and_material(mesh_)) {
      const bool new_object = first || object_of(mesh_, t) != object;
      if (new_object || mesh_.triangle_material[t] != material) {
        if (!first) end_primitive(material);
        object = object_of(mesh_, t);
        material = mesh_.triangle_material[t];
        if (new_object) begin_node(object);
        first = false;
      }
      for (std::size_t corner = 0; corner < 3; ++corner) add_corner(t, corner);
    }
    if (!first) end_primitive(material);
  }

  void begin_node(std::uint32_t object) {
    json_["scenes"][0]["nodes"].push_back(json_["nodes"].size());
    Json node{{"name", "unlabelled"}, {"mesh", json_["meshes"].size()}};
    if (object != kNoObject) {
      const Object& o = mesh_.objects[object];
      node["name"] = o.name;
      node["extras"] = {
          {"instance", object + 1}, {"category", class_name(o.category)}, {"region", o.region}};
    }
    json_["meshes"].push_back({{"name", node["name"]}, {"primitives", Json::array()}});
    json_["nodes"].push_back(std::move(node));
  }

  /// Corners that agree in everything are one vertex of the primitive.
  void add_corner(std::size_t triangle, std::size_t corner) {
    const std::uint32_t position = mesh_.triangles[triangle][corner];
    TexturePoint uv;
    Vec3f normal;
    if (!mesh_.texture_points.empty()) uv = mesh_.texture_points[triangle][corner];
    if (!mesh_.normals.empty()) normal = mesh_.normals[triangle][corner];
    const std::array<float, 5> rest{uv.u, uv.v, normal.x, normal.y, normal.z};
    const auto [vertex, is_new] = vertices_.try_emplace(
        {position, std::bit_cast<std::array<std::uint32_t, 5>>(rest)}, vertices_.size());
    indices_.add(static_cast<std::uint32_t>(vertex->second));
    if (!is_new) return;
    const std::array<float, 3> at = in_file(mesh_.positions[position]);
    for (std::size_t k = 0; k < 3; ++k) {
      low_[k] = vertices_.size() == 1 ? at[k] : std::min(low_[k], at[k]);
      high_[k] = vertices_.size() == 1 ? at[k] : std::max(high_[k], at[k]);
    }
    positions_.add(at);
    if (!mesh_.normals.empty()) normals_.add(in_file(normal));
    if (!mesh_.texture_points.empty()) texture_points_.add(std::array{uv.u, uv.v});
    if (mesh_.colours.empty()) return;
    const Vec3f c = mesh_.colours[position];
    colours_.add(std::array{c.x, c.y, c.z});
  }

  void end_primitive(std::uint32_t material) {
    Json& accessors = json_["accessors"];
    Json primitive{{"attributes", Json::object()}};
    std::size_t view = 0;
    for (const auto& [name, array] :
         {std::pair{"POSITION", &positions_}, std::pair{"NORMAL", &normals_},
          std::pair{"TEXCOORD_0", &texture_points_}, std::pair{"COLOR_0", &colours_}}) {
      if (array->bytes().empty()) continue;
      primitive["attributes"][name] = accessors.size();
      Json& accessor = array->accessor(accessors, view++);
      if (array != &positions_) continue;
      accessor["min"] = low_;
      accessor["max"] = high_;
    }
    primitive["indices"] = accessors.size();
    indices_.accessor(accessors, view);
    primitive["material"] = material;
    json_["meshes"].back()["primitives"].push_back(std::move(primitive));
    vertices_.clear();
  }

  void add_materials(Json& views, std::string& buffer) {
    for (const Material& m : mesh_.materials) {
      Json surface{{"baseColorFactor", {m.colour.x, m.colour.y, m.colour.z, 1}},
                   {"metallicFactor", m.mirror >= .5F ? 1 : 0},
                   {"roughnessFactor", 1 - m.mirror}};
      if (!m.texture.pixels.empty()) {
        surface["baseColorTexture"] = {{"index", json_["textures"].size()}};
        add_texture(m, views, buffer);
      }
      Json material{{"name", m.name}, {"pbrMetallicRoughness", std::move(surface)}};
      const float strength = std::max({m.emission.x, m.emission.y, m.emission.z, 1.0F});
      if (m.emission != Vec3f{}) {
        material["emissiveFactor"] = {m.emission.x / strength, m.emission.y / strength,
                                      m.emission.z / strength};
      }
      if (strength > 1) {
        material["extensions"]["KHR_materials_emissive_strength"] = {
            {"emissiveStrength", strength}};
        json_["extensionsUsed"] = {"KHR_materials_emissive_strength"};
      }
      if (m.cutout > 0) {
        material["alphaMode"] = "MASK";
        material["alphaCutoff"] = m.cutout;
      }
      material["doubleSided"] = true;
      json_["materials"].push_back(std::move(material));
    }
  }

  void add_texture(const Material& material, Json& views, std::string& buffer) {
    if (!json_.contains("samplers")) {
      json_["samplers"] = Json::array({{{"magFilter", kLinear},
                                        {"minFilter", kLinearMipmapLinear},
                                        {"wrapS", kRepeat},
                                        {"wrapT", kRepeat}}});
    }
    const EncodedTexture texture = encode_texture(material.texture);
    buffer.resize((buffer.size() + 3) / 4 * 4);
    json_["textures"].push_back({{"sampler", 0}, {"source", json_["images"].size()}});
    json_["images"].push_back({{"bufferView", views.size()},
                               {"mimeType", texture.suffix == "png" ? "image/png" : "image/jpeg"}});
    views.push_back(
        {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", texture.bytes.size()}});
    buffer.append(texture.bytes.begin(), texture.bytes.end());
  }

  std::string container(std::string buffer) const {
    std::string text = json_.dump(-1, ' ', false, Json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    buffer.resize((buffer.size() + 3) / 4 * 4);
    const std::size_t size = 12 + 8 + text.size() + 8 + buffer.size();
    if (size > 0xffffffffU) throw ArgumentError("a mesh of more than 4 GiB does not fit into GLB");
    std::string out;
    const auto number = [&](std::size_t value) {
      const auto word = static_cast<std::uint32_t>(value);
      out.append(reinterpret_cast<const char*>(&word), 4);
    };
    out += "glTF";
    number(2);
    number(size);
    number(text.size());
    out += "JSON" + text;
    number(buffer.size());
    out.append("BIN\0", 4);
    return out + buffer;
  }

  const Mesh& mesh_;
  bool z_up_;
  Json json_;
  Array positions_{"VEC3", 3, kFloat, kArrayBuffer}, normals_{"VEC3", 3, kFloat, kArrayBuffer},
      texture_points_{"VEC2", 2, kFloat, kArrayBuffer}, colours_{"VEC3", 3, kFloat, kArrayBuffer},
      indices_{"SCALAR", 1, kUnsignedInt, kElementBuffer};
  /// Vertices of the current primitive: position, then the bits of its other attributes.
  std::map<std::pair<std::uint32_t, std::array<std::uint32_t, 5>>, std::size_t> vertices_;
  std::array<float, 3> low_{}, high_{};
};

}  // namespace

std::string to_glb(const Mesh& mesh, UpAxis up) { return GlbWriter(mesh, up).write(); }

std::string to_packed_glb(Mesh mesh) {
  const auto round_to = [](float x, float steps) { return std::round(x * steps) / steps; };
  // Positions that are coarser open cracks between surfaces that meet.
  constexpr float kPosition = 65536, kTexture = 4096, kLight = 512;
  for (Vec3f& p : mesh.positions) {
    p = {round_to(p.x, kPosition), round_to(p.y, kPosition), round_to(p.z, kPosition)};
  }
  for (Vec3f& c : mesh.colours) {
    c = {round_to(c.x, kLight), round_to(c.y, kLight), round_to(c.z, kLight)};
  }
  for (auto& corners : mesh.texture_points) {
    for (TexturePoint& t : corners) t = {round_to(t.u, kTexture), round_to(t.v, kTexture)};
  }
  constexpr int kLevel = 6;
  return gzip(to_glb(mesh), kLevel);
}

void write_glb(const Mesh& mesh, const std::filesystem::path& file) {
  write_file_atomically(file, to_glb(mesh));
}

// --- OBJ
// --------------------------------------------------------------------------------------------

namespace {

/// Names end at blanks in these files, and lines at control bytes.
std::string word(const std::string& name) {
  std::string out = name;
  for (char& c : out) {
    if (c == ' ' || static_cast<unsigned char>(c) < 0x20) c = '_';
  }
  return out;
}
/// Unique, as two materials may have one name.
std::string material_name(const Mesh& mesh, std::size_t place) {
  return fmt::format("{}_{}", place, word(mesh.materials[place].name));
}

void write_materials(const Mesh& mesh, const OutputFolder& folder, const std::string& name) {
  std::string out;
  for (std::size_t i = 0; i < mesh.materials.size(); ++i) {
    const Material& m = mesh.materials[i];
    out += fmt::format("newmtl {}\nKd {} {} {}\n", material_name(mesh, i), m.colour.x, m.colour.y,
                       m.colour.z);
    if (m.emission != Vec3f{}) {
      out += fmt::format("Ke {} {} {}\n", m.emission.x, m.emission.y, m.emission.z);
    }
    if (m.mirror > 0) out += fmt::format("Ks {0} {0} {0}\nillum 3\n", m.mirror);
    if (!m.texture.pixels.empty()) {
      const EncodedTexture texture = encode_texture(m.texture);
      const std::string file = fmt::format("{}_{}.{}", name, i, texture.suffix);
      folder.write(file,
                   {reinterpret_cast<const char*>(texture.bytes.data()), texture.bytes.size()});
      out += fmt::format("map_Kd {}\n", file);
      if (m.cutout > 0) out += fmt::format("map_d {}\n", file);
    }
  }
  folder.write(name + ".mtl", out);
}

void write_points(const Mesh& mesh, fmt::memory_buffer& out) {
  const auto to = std::back_inserter(out);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3f p = mesh.positions[i];
    fmt::format_to(to, "v {} {} {}", p.x, p.y, p.z);
    if (!mesh.colours.empty()) {
      const Vec3f c = mesh.colours[i];
      fmt::format_to(to, " {} {} {}", image::srgb_from_linear(c.x), image::srgb_from_linear(c.y),
                     image::srgb_from_linear(c.z));
    }
    out.push_back('\n');
  }
  for (const auto& corners : mesh.texture_points) {
    for (const TexturePoint p : corners) fmt::format_to(to, "vt {} {}\n", p.u, 1 - p.v);
  }
  for (const auto& corners : mesh.normals) {
    for (const Vec3f n : corners) fmt::format_to(to, "vn {} {} {}\n", n.x, n.y, n.z);
  }
}

/// Each object is one group; what belongs to none comes before the first.
void write_faces(const Mesh& mesh, fmt::memory_buffer& out) {
  const auto to = std::back_inserter(out);
  std::uint32_t object = kNoObject, material = kNoObject;
  for (const std::size_t t : by_object_and_material(mesh)) {
    if (object_of(mesh, t) != object) {
      object = object_of(mesh, t);
      fmt::format_to(to, "g {}_{}\n", object, word(mesh.objects[object].name));
    }
    if (mesh.triangle_material[t] != material) {
      material = mesh.triangle_material[t];
      fmt::format_to(to, "usemtl {}\n", material_name(mesh, material));
    }
    out.push_back('f');
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t own = 3 * t + k + 1;
      fmt::format_to(to, " {}", std::size_t{mesh.triangles[t][k]} + 1);
      if (!mesh.texture_points.empty()) fmt::format_to(to, "/{}", own);
      if (!mesh.normals.empty()) {
        fmt::format_to(to, "{}/{}", mesh.texture_points.empty() ? "/" : "", own);
      }
    }
    out.push_back('\n');
  }
}

}  // namespace

void write_obj(const Mesh& mesh, const std::filesystem::path& folder, const std::string& name) {
  write_obj(mesh, OutputFolder(folder), name);
}

void write_obj(const Mesh& mesh, const OutputFolder& to, const std::string& name) {
  write_materials(mesh, to, name);
  fmt::memory_buffer out;
  fmt::format_to(std::back_inserter(out), "mtllib {}.mtl\n", name);
  write_points(mesh, out);
  write_faces(mesh, out);
  to.write(name + ".obj", {out.data(), out.size()});
}

}  // namespace enfilade::mesh
