#include "enfilade/mesh/mesh.h"

#include <fmt/format.h>
#include <cmath>
#include <utility>

#include "enfilade/mesh/detail/vector.h"

namespace enfilade::mesh {
namespace {

bool finite(Vec3f v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool finite(TexturePoint p) { return std::isfinite(p.u) && std::isfinite(p.v); }
bool within(float value, float low, float high) { return value >= low && value <= high; }

/// In double precision: squares of a sliver's sides leave float's range.
Vec3d twice_area(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  const auto corner = [&](std::size_t k) { return to_double(mesh.positions[triangle[k]]); };
  return cross(corner(1) - corner(0), corner(2) - corner(0));
}

Vec3f normal_of(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  return detail::unit(twice_area(mesh, triangle), {0, 0, 1});
}

std::vector<std::array<Vec3f, 3>> normals_or_flat(const Mesh& mesh) {
  if (!mesh.normals.empty()) return mesh.normals;
  std::vector<std::array<Vec3f, 3>> flat;
  flat.reserve(mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    const Vec3f n = normal_of(mesh, triangle);
    flat.push_back({n, n, n});
  }
  return flat;
}

/// Joins two optional lists whose owners have `size` and `part_size` items.
template <class T>
void append_list(std::vector<T>& list, std::size_t size, const std::vector<T>& part,
                 std::size_t part_size, const T& neutral) {
  if (list.empty() && part.empty()) return;
  list.resize(size, neutral);
  list.insert(list.end(), part.begin(), part.end());
  list.resize(size + part_size, neutral);
}

/// Reports one fault of each kind, with their number: a broken mesh can have millions.
class Checker {
 public:
  Checker(const Mesh& mesh, const std::string& file) : mesh_(mesh), file_(file) {}

  std::vector<Diagnostic> check() {
    if (mesh_.triangles.empty()) error("", "no-triangles", "no triangles, at least 1 is needed");
    check_lengths();
    const bool lists = found_.empty();  // else indices cannot be looked up
    check_materials();
    check_values();
    if (lists && check_indices() && check_positions()) check_size();
    return std::move(found_);
  }

 private:
  void error(std::string where, std::string code, std::string message) {
    found_.push_back(
        {Severity::kError, file_, std::move(where), std::move(code), std::move(message)});
  }
  void warn(std::string code, std::string message) {
    found_.push_back({Severity::kWarning, file_, "", std::move(code), std::move(message)});
  }

  void check_length(const char* name, std::size_t size, std::size_t wanted, bool optional) {
    if (size == wanted || (optional && size == 0)) return;
    error(name, "list-length",
          fmt::format("{} entries, not {}{}", size, wanted, optional ? " or 0" : ""));
  }
  void check_lengths() {
    const std::size_t n = mesh_.triangles.size();
    check_length("triangle_material", mesh_.triangle_material.size(), n, false);
    check_length("triangle_object", mesh_.triangle_object.size(), n, true);
    check_length("texture_points", mesh_.texture_points.size(), n, true);
    check_length("normals", mesh_.normals.size(), n, true);
    check_length("colours", mesh_.colours.size(), mesh_.positions.size(), true);
  }

  /// Reports the first of the items for which `bad` holds, and how many there are.
  template <class Items, class Bad>
  bool none(const char* list, const char* code, const char* what, const Items& items,
            const Bad& bad) {
    std::size_t count = 0, first = 0;
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (bad(items[i]) && count++ == 0) first = i;
    }
    if (count == 0) return true;
    error(fmt::format("{}[{}]", list, first), code,
          fmt::format("{} of {} {}", count, items.size(), what));
    return false;
  }

  bool check_indices() {
    const std::size_t positions = mesh_.positions.size(), materials = mesh_.materials.size(),
                      objects = mesh_.objects.size();
    const bool corners = none(
        "triangles", "bad-index", "point to positions that are not there", mesh_.triangles,
        [&](const auto& t) { return t[0] >= positions || t[1] >= positions || t[2] >= positions; });
    const bool material =
        none("triangle_material", "bad-index", "point to materials that are not there",
             mesh_.triangle_material, [&](std::uint32_t m) { return m >= materials; });
    const bool object = none("triangle_object", "bad-index", "point to objects that are not there",
                             mesh_.triangle_object,
                             [&](std::uint32_t o) { return o >= objects && o != kNoObject; });
    return corners && material && object;
  }
  /// Positions that no triangle uses are not checked.
  bool check_positions() {
    return none("triangles", "not-finite", "have corners that are not finite", mesh_.triangles,
                [&](const auto& t) {
                  return !finite(mesh_.positions[t[0]]) || !finite(mesh_.positions[t[1]]) ||
                         !finite(mesh_.positions[t[2]]);
                });
  }
  void check_values() {
    const auto any_not_finite = [](const auto& corners) {
      return !finite(corners[0]) || !finite(corners[1]) || !finite(corners[2]);
    };
    none("texture_points", "not-finite", "are not finite", mesh_.texture_points, any_not_finite);
    none("normals", "not-finite", "are not finite", mesh_.normals, any_not_finite);
    none("colours", "not-finite", "are not finite", mesh_.colours,
         [](Vec3f colour) { return !finite(colour); });
  }

  void bad_material(std::size_t place, std::string message) {
    error(fmt::format("materials[{}]", place), "bad-material", std::move(message));
  }
  void check_materials() {
    for (std::size_t i = 0; i < mesh_.materials.size(); ++i) {
      const Material& m = mesh_.materials[i];
      const Vec3f c = m.colour, e = m.emission;
      if (!within(c.x, 0, 1) || !within(c.y, 0, 1) || !within(c.z, 0, 1)) {
        bad_material(i, fmt::format("colour ({}, {}, {}), not within [0, 1]", c.x, c.y, c.z));
      }
      if (!finite(e) || e.x < 0 || e.y < 0 || e.z < 0) {
        bad_material(i, fmt::format("emission ({}, {}, {}), not 0 or more", e.x, e.y, e.z));
      }
      if (!within(m.mirror, 0, 1)) {
        bad_material(i, fmt::format("mirror {}, not within [0, 1]", m.mirror));
      }
      if (!within(m.cutout, 0, 1)) {
        bad_material(i, fmt::format("cutout {}, not within [0, 1]", m.cutout));
      }
      check_texture(i, m);
    }
  }
  void check_texture(std::size_t i, const Material& m) {
    const image::Image8& t = m.texture;
    if (t.pixels.empty()) {
      if (t.width != 0 && t.height != 0) bad_material(i, "a texture with a size but no pixels");
      if (m.cutout > 0) bad_material(i, "cut-outs without a texture");
      return;
    }
    if (t.channels != 3 && t.channels != 4) {
      bad_material(i, fmt::format("a texture of {} channels, not 3 or 4", t.channels));
    } else if (t.pixels.size() != std::size_t{t.width} * t.height * t.channels) {
      bad_material(i, fmt::format("a texture of {} bytes, not {} x {} x {}", t.pixels.size(),
                                  t.width, t.height, t.channels));
    }
    if (m.cutout > 0 && t.channels != 4) {
      bad_material(i, fmt::format("cut-outs with a texture of {} channels, not 4", t.channels));
    }
  }

  void check_size() {
    if (mesh_.triangles.empty()) return;
    constexpr double kSmallest = 0.5, kLargest = 2000;  // metres; as the header says
    const Box box = bounds(mesh_);
    const double across =
        length(Vec3d{box.high.x, box.high.y, box.high.z} - Vec3d{box.low.x, box.low.y, box.low.z});
    if (across < kSmallest || across > kLargest) {
      warn("absurd-size", fmt::format("{:g} m across, {} {} m: wrong units?", across,
                                      across < kSmallest ? "less than" : "more than",
                                      across < kSmallest ? kSmallest : kLargest));
    }
    const auto flat = std::ranges::count_if(
        mesh_.triangles, [&](const auto& t) { return !(length(twice_area(mesh_, t)) > 0); });
    if (flat > 0) {
      warn("degenerate-triangles",
           fmt::format("{} of {} triangles have no area", flat, mesh_.triangles.size()));
    }
  }

  const Mesh& mesh_;
  const std::string& file_;
  std::vector<Diagnostic> found_;
};

/// From the lower end, whichever way a triangle runs along it, so that neighbours meet exactly.
Vec3f crossing(Vec3f low, Vec3f high, float z) {
  const float share = (z - low.z) / (high.z - low.z);
  return {low.x + share * (high.x - low.x), low.y + share * (high.y - low.y), z};
}

}  // namespace

Box bounds(const Mesh& mesh) {
  const Vec3f first = mesh.positions[mesh.triangles.front()[0]];
  Box box{first, first};
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) {
      const Vec3f p = mesh.positions[corner];
      box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
      box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
    }
  }
  return box;
}

Vec3f face_normal(const Mesh& mesh, std::size_t triangle) {
  return normal_of(mesh, mesh.triangles[triangle]);
}

void append(Mesh& mesh, const Mesh& part) {
  if (&mesh == &part) {
    append(mesh, Mesh(part));
    return;
  }
  const std::size_t triangles = mesh.triangles.size(), more = part.triangles.size();
  if (!mesh.normals.empty() || !part.normals.empty()) {
    mesh.normals = normals_or_flat(mesh);
    const auto added = normals_or_flat(part);
    mesh.normals.insert(mesh.normals.end(), added.begin(), added.end());
  }
  append_list(mesh.texture_points, triangles, part.texture_points, more, {});
  append_list(mesh.colours, mesh.positions.size(), part.colours, part.positions.size(), {1, 1, 1});

  const auto first_position = static_cast<std::uint32_t>(mesh.positions.size());
  const auto first_material = static_cast<std::uint32_t>(mesh.materials.size());
  const auto first_object = static_cast<std::uint32_t>(mesh.objects.size());
  append_list(mesh.triangle_object, triangles, part.triangle_object, more, kNoObject);
  for (std::size_t t = triangles; t < mesh.triangle_object.size(); ++t) {
    if (mesh.triangle_object[t] != kNoObject) mesh.triangle_object[t] += first_object;
  }
  for (const auto& t : part.triangles) {
    mesh.triangles.push_back({t[0] + first_position, t[1] + first_position, t[2] + first_position});
  }
  for (const std::uint32_t m : part.triangle_material) {
    mesh.triangle_material.push_back(m + first_material);
  }
  mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
  mesh.materials.insert(mesh.materials.end(), part.materials.begin(), part.materials.end());
  mesh.objects.insert(mesh.objects.end(), part.objects.begin(), part.objects.end());
}

std::vector<Diagnostic> check(const Mesh& mesh, const std::string& file) {
  return Checker(mesh, file).check();
}

std::vector<SliceLine> slice(const Mesh& mesh, float z) {
  std::vector<SliceLine> lines;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Vec3f, 2> ends;
    std::size_t found = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f a = mesh.positions[mesh.triangles[t][k]];
      const Vec3f b = mesh.positions[mesh.triangles[t][(k + 1) % 3]];
      // Half-open, so that a corner in the plane counts once.
      if ((a.z < z) == (b.z < z)) continue;
      ends[found++] = a.z < b.z ? crossing(a, b, z) : crossing(b, a, z);
    }
    if (found != 2 || ends[0] == ends[1]) continue;
    lines.push_back({ends[0], ends[1], object_of(mesh, t)});
  }
  return lines;
}

}  // namespace enfilade::mesh
