#include <fmt/format.h>
#include <algorithm>
#include <iterator>
#include <numeric>

#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/tone.h"
#include "enfilade/mesh/read_mesh.h"

namespace enfilade::mesh {
namespace {

constexpr int kQuality = 92;  // above it files grow faster than differences shrink

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
std::string texture_name(const std::string& name, std::size_t place, bool png) {
  return fmt::format("{}_{}.{}", name, place, png ? "png" : "jpg");
}

void write_bytes(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
  write_file_atomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
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
      const bool cutouts = m.texture.channels == 4;
      const std::string file = texture_name(name, i, cutouts);
      write_bytes(folder / file,
                  cutouts ? image::encode_png(m.texture) : image::encode_jpeg(m.texture, kQuality));
      out += fmt::format("map_Kd {}\n", file);
      if (m.cutout > 0) out += fmt::format("map_d {}\n", file);
    }
  }
  write_file_atomically(folder / (name + ".mtl"), out);
}

std::uint32_t object_of(const Mesh& mesh, std::size_t triangle) {
  return mesh.triangle_object.empty() ? kNoObject : mesh.triangle_object[triangle];
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

/// By object, then by material: each group is written once.
void write_faces(const Mesh& mesh, fmt::memory_buffer& out) {
  std::vector<std::size_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // kNoObject + 1 is 0: what is no object comes before the first group.
  const auto key = [&](std::size_t t) {
    return std::pair(object_of(mesh, t) + 1, mesh.triangle_material[t]);
  };
  std::ranges::stable_sort(order, {}, key);
  const auto to = std::back_inserter(out);
  std::uint32_t object = kNoObject, material = kNoObject;
  for (const std::size_t t : order) {
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
