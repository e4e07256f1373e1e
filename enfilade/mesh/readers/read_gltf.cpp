#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <ranges>
#include <utility>

#include "enfilade/mesh/readers/gltf.h"

namespace enfilade::mesh::readers {
namespace {

using tinygltf::Model;

/// 4 x 4 with a last row of 0 0 0 1: row-major 3 x 4.
struct Affine {
  std::array<double, 12> m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  Vec3f point(const double* p) const {
    const auto row = [&](std::size_t r) {
      return static_cast<float>(m[4 * r] * p[0] + m[4 * r + 1] * p[1] + m[4 * r + 2] * p[2] +
                                m[4 * r + 3]);
    };
    return {row(0), row(1), row(2)};
  }
  /// Multiplies by the matrix of cofactors, which is the inverse transpose up to a factor.
  Vec3f normal(const double* n) const {
    const auto cofactor = [&](std::size_t r, std::size_t c) {
      const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
      return m[4 * r1 + c1] * m[4 * r2 + c2] - m[4 * r1 + c2] * m[4 * r2 + c1];
    };
    const auto row = [&](std::size_t r) {
      return static_cast<float>(cofactor(r, 0) * n[0] + cofactor(r, 1) * n[1] +
                                cofactor(r, 2) * n[2]);
    };
    return {row(0), row(1), row(2)};
  }
  friend Affine operator*(const Affine& a, const Affine& b) {
    Affine out;
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 4; ++c) {
        double sum = c == 3 ? a.m[4 * r + 3] : 0;
        for (std::size_t k = 0; k < 3; ++k) sum += a.m[4 * r + k] * b.m[4 * k + c];
        out.m[4 * r + c] = sum;
      }
    }
    return out;
  }
};

Affine affine_of(const tinygltf::Node& node) {
  Affine out;
  if (node.matrix.size() == 16) {  // column-major
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 4; ++c) out.m[4 * r + c] = node.matrix[4 * c + r];
    }
    return out;
  }
  std::array<double, 4> q{0, 0, 0, 1};
  if (node.rotation.size() == 4) std::copy_n(node.rotation.begin(), 4, q.begin());
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& v : q) v /= size;  // not a number for length 0; the caller checks that
  const auto [x, y, z, w] = q;
  out.m = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),     0,
           2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),     0,
           2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y), 0};
  for (std::size_t k = 0; k < 3; ++k) {
    if (node.scale.size() == 3) {
      for (std::size_t r = 0; r < 3; ++r) out.m[4 * r + k] *= node.scale[k];
    }
    if (node.translation.size() == 3) out.m[4 * k + 3] = node.translation[k];
  }
  return out;
}

/// What a primitive's vertices have.
struct Vertices {
  GltfNumbers positions;
  std::optional<GltfNumbers> normals, colours, texture_points;  ///< as many as positions
};

class SceneReader {
 public:
  explicit SceneReader(const Source& source) : source_(source), model_(load_gltf(source, out_)) {}

  ReadResult read() {
    materials_ = read_gltf_materials(model_, source_, out_);
    for (GltfMaterial& m : materials_) {
      mesh_.mesh.materials.push_back(std::move(m.material));
    }
    read_nodes();
    const auto tell = [&](const char* what, std::size_t n) {
      if (n > 0) warn(out_, source_.name, "", "left-out", fmt::format("{} {}", n, what));
    };
    tell("animations", model_.animations.size());
    tell("skins: meshes are as bound", model_.skins.size());
    tell("cameras", model_.cameras.size());
    tell("lights", model_.lights.size());
    tell("primitives with morph targets: taken as unmoved", morphed_);
    tell("primitives of points or lines", thin_);
    warn(out_, source_.name, odd_.normals, "not-finite",
         "normals are not finite numbers: those of the faces are taken");
    warn(out_, source_.name, odd_.texture_points, "not-finite",
         "texture points are not finite numbers: taken as 0");
    warn(out_, source_.name, odd_.colours, "not-finite",
         "colours are not finite numbers: taken as white");
    warn(out_, source_.name, odd_.bright, "bad-value", "colours are far above 1: taken as 1");
    for (auto& [kind, left_out] : left_out_) {
      auto& [first, times] = left_out;
      if (times > 1) first.message += fmt::format(", and {} more like it", times - 1);
      out_.warnings.push_back(std::move(first));
    }
    out_.mesh = mesh_.finish();
    return std::move(out_);
  }

 private:
  [[noreturn]] void fail(std::string where, const char* code, std::string message) const {
    refuse(source_.name, std::move(where), code, std::move(message));
  }

  struct Visit {
    int node;
    Affine world_from_parent;
  };
  std::vector<int> roots() const {
    if (!model_.scenes.empty()) {
      const int number = std::max(model_.defaultScene, 0);
      const tinygltf::Scene* scene = item_at(model_.scenes, number);
      if (scene != nullptr) return scene->nodes;
      fail("$.scene", "bad-index", fmt::format("{} of {}", number, model_.scenes.size()));
    }
    std::vector<bool> child(model_.nodes.size());
    for (const tinygltf::Node& node : model_.nodes) {
      for (const int c : node.children) {
        if (item_at(model_.nodes, c) != nullptr) child[static_cast<std::size_t>(c)] = true;
      }
    }
    std::vector<int> out;
    for (std::size_t n = 0; n < child.size(); ++n) {
      if (!child[n]) out.push_back(static_cast<int>(n));
    }
    return out;
  }
  /// In the file's order: a node, then its children.
  void read_nodes() {
    std::vector<Visit> open;
    const auto push = [&](const std::vector<int>& nodes, const Affine& parent) {
      for (const int node : std::views::reverse(nodes)) open.push_back({node, parent});
    };
    push(roots(), {});
    std::vector<bool> seen(model_.nodes.size());
    while (!open.empty()) {
      const Visit visit = open.back();
      open.pop_back();
      const std::string where = fmt::format("$.nodes[{}]", visit.node);
      const tinygltf::Node* node = item_at(model_.nodes, visit.node);
      if (node == nullptr) fail(where, "bad-index", fmt::format("only {} are there", seen.size()));
      const auto n = static_cast<std::size_t>(visit.node);
      if (seen[n]) fail(where, "bad-node", "a child of two nodes, or of itself");
      seen[n] = true;
      const Affine world = visit.world_from_parent * affine_of(*node);
      if (!std::ranges::all_of(world.m, [](double v) { return std::isfinite(v); })) {
        fail(where, "not-finite", "its transform is not finite");
      }
      if (node->mesh >= 0) read_mesh_of(*node, n, world);
      push(node->children, world);
    }
  }

  void read_mesh_of(const tinygltf::Node& node, std::size_t place, const Affine& world) {
    const std::string where = fmt::format("$.meshes[{}]", node.mesh);
    const tinygltf::Mesh* mesh = item_at(model_.meshes, node.mesh);
    if (mesh == nullptr) {
      fail(where, "bad-index", fmt::format("only {} are there", model_.meshes.size()));
    }
    std::string name = !node.name.empty()    ? node.name
                       : !mesh->name.empty() ? mesh->name
                                             : fmt::format("node {}", place);
    mesh_.mesh.objects.push_back({std::move(name), 0, -1});
    for (std::size_t p = 0; p < mesh->primitives.size(); ++p) {
      read_primitive(mesh->primitives[p], fmt::format("{}.primitives[{}]", where, p), world);
    }
  }

  /// Instances of one mesh can make a small file into any number of triangles. Without them, a byte
  /// holds at most one index; furniture is not repeated more often than it has bytes.
  void spend(std::size_t n, const std::string& where) {
    spent_ += n;
    if (spent_ <= most_) return;
    fail(where, "too-large",
         fmt::format("its meshes are repeated so often that they have more than {} vertices and "
                     "indices",
                     most_));
  }

  std::optional<GltfNumbers> attribute(const tinygltf::Primitive& primitive,
                                       std::optional<DracoPrimitive>& draco,
                                       const std::string& name, std::size_t least, std::size_t most,
                                       const std::string& where) {
    GltfNumbers out;
    const auto at = primitive.attributes.find(name);
    if (draco && draco->attributes.contains(name)) {
      out = std::move(draco->attributes.at(name));
    } else if (at != primitive.attributes.end()) {
      out = read_accessor(model_, at->second, source_.name);
    } else {
      return std::nullopt;
    }
    if (out.components < least || out.components > most) {
      fail(where, "bad-accessor", fmt::format("{} of {} numbers", name, out.components));
    }
    spend(out.count, where);
    return out;
  }
  /// Keeps the first warning of a code about `what`; the others are counted.
  void leave_out(const Diagnostic& found, const std::string& what) {
    std::string kind = what + " " + found.code;
    ++left_out_.try_emplace(std::move(kind), found, 0).first->second.second;
  }
  /// The same for what a mesh can do without: a fault is a warning, and nothing is given.
  std::optional<GltfNumbers> optional_attribute(const tinygltf::Primitive& primitive,
                                                std::optional<DracoPrimitive>& draco,
                                                const std::string& name, std::size_t components,
                                                std::size_t most, std::size_t vertices,
                                                const std::string& where) {
    try {
      auto out = attribute(primitive, draco, name, components, most, where);
      if (out && out->count != vertices) {
        fail(where, "list-length",
             fmt::format("an attribute of {} vertices, not {}", out->count, vertices));
      }
      return out;
    } catch (const InvalidInput& e) {
      const Diagnostic& found = e.diagnostics().front();
      if (found.code == "too-large") throw;
      leave_out({Severity::kWarning, source_.name, found.where, found.code,
                 fmt::format("{}: {} is left out", found.message, name)},
                name);
      return std::nullopt;
    }
  }
  Vertices read_vertices(const tinygltf::Primitive& primitive, std::optional<DracoPrimitive>& draco,
                         const GltfTexturePlace& place, const std::string& where) {
    Vertices out;
    auto positions = attribute(primitive, draco, "POSITION", 3, 3, where);
    if (!positions) fail(where, "missing-attribute", "no POSITION");
    out.positions = std::move(*positions);
    const std::size_t n = out.positions.count;
    out.normals = optional_attribute(primitive, draco, "NORMAL", 3, 3, n, where);
    out.colours = optional_attribute(primitive, draco, "COLOR_0", 3, 4, n, where);
    if (place.set >= 0) {
      out.texture_points = optional_attribute(
          primitive, draco, fmt::format("TEXCOORD_{}", place.set), 2, 2, n, where);
    }
    return out;
  }
  /// The accessor of a primitive's indices, or where rewrite_gltf() keeps its number.
  static int index_accessor(const tinygltf::Primitive& primitive) {
    const auto kept = primitive.extensions.find(std::string(kKeptIndices));
    if (kept == primitive.extensions.end() || !kept->second.IsObject()) return primitive.indices;
    const tinygltf::Value& number = kept->second.Get("accessor");
    return number.IsInt() ? number.Get<int>() : -1;
  }
  std::vector<std::uint32_t> read_indices(const tinygltf::Primitive& primitive,
                                          std::optional<DracoPrimitive>& draco,
                                          std::size_t vertices, const std::string& where) {
    if (draco) {
      spend(draco->indices.size(), where);
      for (const std::uint32_t index : draco->indices) check_index(index, vertices, where);
      return std::move(draco->indices);
    }
    std::vector<std::uint32_t> out;
    const int accessor = index_accessor(primitive);
    if (accessor < 0) {
      for (std::size_t i = 0; i < vertices; ++i) out.push_back(static_cast<std::uint32_t>(i));
      return out;
    }
    const GltfNumbers numbers = read_accessor(model_, accessor, source_.name);
    if (numbers.components != 1 || !numbers.whole) {
      fail(where, "bad-accessor", "indices that are not unsigned whole numbers");
    }
    spend(numbers.count, where);
    out.reserve(numbers.count);
    for (const double value : numbers.values) {
      check_index(value, vertices, where);
      out.push_back(static_cast<std::uint32_t>(value));
    }
    return out;
  }
  void check_index(double value, std::size_t vertices, const std::string& where) const {
    if (value >= static_cast<double>(vertices)) {
      fail(where, "bad-index", fmt::format("vertex {} of {}", value, vertices));
    }
  }

  std::uint32_t material_of(const tinygltf::Primitive& primitive, const std::string& where) {
    if (item_at(materials_, primitive.material) != nullptr) {
      return static_cast<std::uint32_t>(primitive.material);
    }
    if (primitive.material >= 0) {
      leave_out(
          {Severity::kWarning, source_.name, where, "bad-index",
           fmt::format("material {} of {}: taken as white", primitive.material, materials_.size())},
          "material");
    }
    if (!default_material_) {
      default_material_ = static_cast<std::uint32_t>(mesh_.mesh.materials.size());
      mesh_.mesh.materials.emplace_back().colour = {1, 1, 1};  // as the format says
    }
    return *default_material_;
  }

  void read_primitive(const tinygltf::Primitive& primitive, const std::string& where,
                      const Affine& world) {
    int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode < TINYGLTF_MODE_TRIANGLES) {
      ++thin_;
      return;
    }
    if (mode > TINYGLTF_MODE_TRIANGLE_FAN) {
      fail(where, "bad-mode", fmt::format("mode {}, not 0 to 6", mode));
    }
    if (!primitive.targets.empty()) ++morphed_;
    std::optional<DracoPrimitive> draco = read_draco(model_, primitive, source_.name, where);
    if (draco) mode = TINYGLTF_MODE_TRIANGLES;  // decoded strips are triangles
    const std::uint32_t material = material_of(primitive, where);
    const GltfTexturePlace place =
        material < materials_.size() ? materials_[material].place : GltfTexturePlace{};
    const Vertices vertices = read_vertices(primitive, draco, place, where);
    const auto indices = read_indices(primitive, draco, vertices.positions.count, where);
    where_ = where;
    used_.assign(vertices.positions.count, std::nullopt);
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      mesh_.add(
          {corner(indices[a], vertices, place, world), corner(indices[b], vertices, place, world),
           corner(indices[c], vertices, place, world)},
          material, static_cast<std::uint32_t>(mesh_.mesh.objects.size() - 1));
    };
    if (mode == TINYGLTF_MODE_TRIANGLES) {
      for (std::size_t i = 0; i + 3 <= indices.size(); i += 3) add(i, i + 1, i + 2);
    } else if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
      for (std::size_t i = 2; i < indices.size(); ++i) add(0, i - 1, i);
    } else {  // every second triangle of a strip has the other orientation
      for (std::size_t i = 2; i < indices.size(); ++i) {
        add(i - 2, i - 1 + i % 2, i - i % 2);
      }
    }
  }

  /// The vertex in our lists; added when the first triangle uses it.
  const CornerIndices& corner(std::uint32_t index, const Vertices& vertices,
                              const GltfTexturePlace& place, const Affine& world) {
    std::optional<CornerIndices>& out = used_[index];
    if (out) return *out;
    Mesh& mesh = mesh_.mesh;
    out.emplace();
    out->position = static_cast<std::uint32_t>(mesh.positions.size());
    const double* p = vertices.positions.values.data() + 3 * std::size_t{index};
    mesh.positions.push_back(world.point(p));
    if (!is_finite(mesh.positions.back())) {
      fail(where_, "not-finite",
           fmt::format("vertex {} at ({}, {}, {}), and a triangle uses it", index, p[0], p[1],
                       p[2]));
    }
    if (vertices.normals) add_normal(*vertices.normals, index, world, *out);
    if (vertices.texture_points) add_texture_point(*vertices.texture_points, index, place, *out);
    Vec3f colour{1, 1, 1};
    if (vertices.colours) {
      mesh_.coloured = true;
      const double* c = vertices.colours->values.data() + vertices.colours->components * index;
      const auto share = [](double v) { return static_cast<float>(std::clamp(v, 0.0, 1.0)); };
      if (std::isfinite(c[0]) && std::isfinite(c[1]) && std::isfinite(c[2])) {
        colour = {share(c[0]), share(c[1]), share(c[2])};
        if (std::max({c[0], c[1], c[2]}) >= kLeastColourByte) {
          odd_.bright.add([&] { return where_; });
        }
      } else {
        odd_.colours.add([&] { return where_; });
      }
    }
    mesh.colours.push_back(colour);
    return *out;
  }

  void add_normal(const GltfNumbers& normals, std::uint32_t index, const Affine& world,
                  CornerIndices& out) {
    Vec3f normal = world.normal(normals.values.data() + 3 * std::size_t{index});
    if (!is_finite(normal)) {
      odd_.normals.add([&] { return where_; });
      normal = {};  // the face's
    }
    out.normal = static_cast<std::uint32_t>(mesh_.normals.size());
    mesh_.normals.push_back(normal);
  }
  void add_texture_point(const GltfNumbers& points, std::uint32_t index,
                         const GltfTexturePlace& place, CornerIndices& out) {
    const double* uv = points.values.data() + 2 * std::size_t{index};
    const auto& m = place.map;
    const float u = to_float_or_nan(m[0] * uv[0] + m[1] * uv[1] + m[2]),
                v = to_float_or_nan(m[3] * uv[0] + m[4] * uv[1] + m[5]);
    const bool good = std::isfinite(u) && std::isfinite(v);
    if (!good) odd_.texture_points.add([&] { return where_; });
    out.texture_point = static_cast<std::uint32_t>(mesh_.texture_points.size());
    mesh_.texture_points.push_back(good ? TexturePoint{u, v} : TexturePoint{});
  }

  const Source& source_;
  ReadResult out_;  // before the model, whose reader warns
  Model model_;
  MeshCollector mesh_;
  std::vector<GltfMaterial> materials_;
  std::optional<std::uint32_t> default_material_;
  std::vector<std::optional<CornerIndices>> used_;
  std::size_t most_ = most_items(model_);
  std::size_t spent_ = 0, morphed_ = 0, thin_ = 0;
  std::map<std::string, std::pair<Diagnostic, std::size_t>> left_out_;  ///< see leave_out()
  std::string where_;                                                   ///< of the primitive
  struct {
    OddValues normals, texture_points, colours, bright;
  } odd_;
};

}  // namespace

ReadResult read_gltf(const Source& source) { return SceneReader(source).read(); }

}  // namespace enfilade::mesh::readers
