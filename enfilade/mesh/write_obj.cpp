#include <fmt/format.h>
#include <iterator>

#include "enfilade/core/file.h"
#include "enfilade/image/tone.h"
#include "enfilade/mesh/detail/writer.h"
#include "enfilade/mesh/read_mesh.h"

namespace enfilade::mesh {
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

void write_materials(const Mesh& mesh, const std::filesystem::path& folder,
                     const std::string& name) {
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
      const detail::EncodedTexture texture = detail::encode_texture(m.texture);
      const std::string file = fmt::format("{}_{}.{}", name, i, texture.suffix);
      write_file_atomically(folder / file, {reinterpret_cast<const char*>(texture.bytes.data()),
                                            texture.bytes.size()});
      out += fmt::format("map_Kd {}\n", file);
      if (m.cutout > 0) out += fmt::format("map_d {}\n", file);
    }
  }
  write_file_atomically(folder / (name + ".mtl"), out);
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
  for (const std::size_t t : detail::by_object_and_material(mesh)) {
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
  make_folder(folder);
  write_materials(mesh, folder, name);
  fmt::memory_buffer out;
  fmt::format_to(std::back_inserter(out), "mtllib {}.mtl\n", name);
  write_points(mesh, out);
  write_faces(mesh, out);
  write_file_atomically(folder / (name + ".obj"), {out.data(), out.size()});
}

}  // namespace enfilade::mesh
