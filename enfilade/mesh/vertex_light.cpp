#include "enfilade/mesh/lighting.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/tone.h"
#include "enfilade/mesh/detail/vector.h"

namespace enfilade::mesh {

using namespace detail;

namespace {

/// The object of what lies outside of all rooms.
constexpr std::uint32_t kSurroundings = 1;
/// How many times longer edges may stay there.
constexpr double kOutside = 4;

/// A corner: where it is, and what was found there.
struct Corner {
  Vec3f position;
  TexturePoint texture;
  Vec3f light;
};

/// A part of a triangle: its corners, and where in the triangle they are (weights of corners 1 and
/// 2, as Hit's u and v).
struct Piece {
  std::uint32_t triangle = 0;
  std::array<std::uint32_t, 3> corners{};
  std::array<std::array<float, 2>, 3> at{};
};

/// What is between two corners: a corner, and whether the edge is cut there.
struct Middle {
  std::uint32_t corner = 0;
  bool cut = false;
};

void check_options(const VertexLightOptions& o) {
  if (!(o.least_edge > 0) || !std::isfinite(o.least_edge)) {
    throw ArgumentError(fmt::format("least_edge: {}, not above 0", o.least_edge));
  }
  if (!(o.most_edge >= o.least_edge)) {
    throw ArgumentError(
        fmt::format("most_edge: {}, below least_edge ({})", o.most_edge, o.least_edge));
  }
  if (!(o.tolerance > 0 && o.tolerance <= 1)) {
    throw ArgumentError(fmt::format("tolerance: {}, not in (0, 1]", o.tolerance));
  }
}

class Cutter {
 public:
  Cutter(const Mesh& mesh, const SurfaceLight& light, const VertexLightOptions& options)
      : light_(light), mesh_(mesh), options_(options), surroundings_(mesh_) {}

  Mesh run() {
    make_whole_triangles();
    do {
      measure_edges();
    } while (cut() && pieces_.size() < options_.most_triangles);
    return finish();
  }

 private:
  /// Corners of triangles that look alike are one: then the edge between them is one, too.
  void make_whole_triangles() {
    using Key = std::tuple<std::array<std::uint32_t, 8>, std::uint32_t>;
    std::map<Key, std::uint32_t> known;
    std::vector<SurfacePoint> points;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      Piece piece{t, {}, {{{0, 0}, {1, 0}, {0, 1}}}};
      const Vec3f flat = face_normal(mesh_, t);
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3f p = mesh_.positions[mesh_.triangles[t][k]];
        const Vec3f n = mesh_.normals.empty() ? flat : mesh_.normals[t][k];
        const TexturePoint uv =
            mesh_.texture_points.empty() ? TexturePoint{} : mesh_.texture_points[t][k];
        // Normals to a thousandth: those of one plane differ in their last bits.
        const auto part = [](float x) { return std::round(x * 1000) + 0.0F; };
        const std::array<float, 8> values{p.x,       p.y,       p.z,  part(n.x),
                                          part(n.y), part(n.z), uv.u, uv.v};
        const Key key{std::bit_cast<std::array<std::uint32_t, 8>>(values),
                      2 * mesh_.triangle_material[t] + (surroundings_.has(t) ? 1 : 0)};
        const auto [found, is_new] =
            known.try_emplace(key, static_cast<std::uint32_t>(corners_.size()));
        piece.corners[k] = found->second;
        if (!is_new) continue;
        corners_.push_back({p, uv, {}});
        points.push_back(inside(t, piece.at[k]));
      }
      pieces_.push_back(piece);
    }
    light_up(0, points);
  }

  /// A little towards the triangle's middle: at its very edge other surfaces stand.
  SurfacePoint inside(std::uint32_t triangle, std::array<float, 2> at) const {
    constexpr float kInset = 0.02F, kMetres = 0.004F;
    const auto& [a, b, c] = mesh_.triangles[triangle];
    const float size = std::max({length(mesh_.positions[b] - mesh_.positions[a]),
                                 length(mesh_.positions[c] - mesh_.positions[a]), 1e-6F});
    const float inset = std::min(kInset, kMetres / size);
    const auto moved = [inset](float x) { return x + inset * (1.0F / 3 - x); };
    return {triangle, moved(at[0]), moved(at[1]), false};
  }

  void light_up(std::size_t first, const std::vector<SurfacePoint>& points) {
    constexpr std::size_t kGrain = 1024;
    std::vector<Vec3f> found(points.size());
    parallel_for(points.size(), kGrain, options_.threads, [&](std::size_t a, std::size_t b) {
      light_.at(std::span(points).subspan(a, b - a), std::span(found).subspan(a, b - a));
    });
    for (std::size_t k = 0; k < points.size(); ++k) corners_[first + k].light = found[k];
  }

  static std::uint64_t edge(std::uint32_t a, std::uint32_t b) {
    return std::uint64_t{std::min(a, b)} << 32U | std::max(a, b);
  }
  float edge_length(std::uint32_t a, std::uint32_t b) const {
    return length(corners_[a].position - corners_[b].position);
  }

  /// Finds the middles of all edges that may be cut and are not known yet.
  void measure_edges() {
    const std::size_t first = corners_.size();
    std::vector<SurfacePoint> points;
    std::vector<std::array<std::uint32_t, 2>> ends;
    for (const Piece& piece : pieces_) {
      // Lawns are hundreds of metres wide, and seen from afar.
      const bool outside = surroundings_.has(piece.triangle);
      const double least = outside ? kOutside * options_.most_edge : options_.least_edge;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = piece.corners[k], b = piece.corners[(k + 1) % 3];
        if (edge_length(a, b) <= least) continue;
        const auto corner = static_cast<std::uint32_t>(corners_.size());
        const bool too_long = !outside && edge_length(a, b) > options_.most_edge;
        if (!middles_.try_emplace(edge(a, b), Middle{corner, too_long}).second) continue;
        const auto at = middle(piece.at[k], piece.at[(k + 1) % 3]);
        const Corner &from = corners_[a], &to = corners_[b];
        corners_.push_back(
            {0.5F * (from.position + to.position),
             {(from.texture.u + to.texture.u) / 2, (from.texture.v + to.texture.v) / 2},
             {}});
        points.push_back(inside(piece.triangle, at));
        ends.push_back({a, b});
      }
    }
    light_up(first, points);
    for (std::size_t k = 0; k < ends.size(); ++k) {
      const auto [a, b] = ends[k];
      Middle& middle = middles_.find(edge(a, b))->second;
      middle.cut = middle.cut || bends(a, b, corners_[first + k].light);
    }
  }

  static std::array<float, 2> middle(std::array<float, 2> a, std::array<float, 2> b) {
    return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
  }

  /// Whether light there is not what one would interpolate, as a screen shows it.
  bool bends(std::uint32_t a, std::uint32_t b, Vec3f there) const {
    const auto shown = [](Vec3f light) {
      return image::srgb_from_linear(image::shoulder(luminance(light)));
    };
    const float mean = shown(0.5F * (corners_[a].light + corners_[b].light));
    return std::abs(shown(there) - mean) > options_.tolerance;
  }

  /// Halves each piece with an edge to be cut, at its longest edge, which is then to be cut in the
  /// piece beyond it, too (Rivara 1984): no piece becomes a sliver, and in the end edges fit.
  /// Returns whether there was one.
  bool cut() {
    bool any = false;
    const std::size_t count = pieces_.size();
    for (std::uint32_t p = 0; p < count && pieces_.size() < options_.most_triangles; ++p) {
      std::size_t longest = 0;
      std::pair<float, std::uint64_t> most{-1.0F, 0};  // equal lengths: the same in both pieces
      bool wanted = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = pieces_[p].corners[k], b = pieces_[p].corners[(k + 1) % 3];
        const auto found = middles_.find(edge(a, b));
        wanted = wanted || (found != middles_.end() && found->second.cut);
        const std::pair size{edge_length(a, b), edge(a, b)};
        if (size <= most) continue;
        most = size;
        longest = k;
      }
      if (!wanted) continue;
      const auto middle = middles_.find(most.second);
      if (middle == middles_.end()) continue;  // of a piece of this round: in the next
      middle->second.cut = true;
      halve(p, longest);
      any = true;
    }
    return any;
  }

  /// The piece keeps corner k, the new one has the edge's other end.
  void halve(std::uint32_t p, std::size_t k) {
    const std::size_t next = (k + 1) % 3;
    Piece& piece = pieces_[p];
    Piece other = piece;
    const std::uint32_t corner =
        middles_.find(edge(piece.corners[k], piece.corners[next]))->second.corner;
    const auto at = middle(piece.at[k], piece.at[next]);
    piece.corners[next] = other.corners[k] = corner;
    piece.at[next] = other.at[k] = at;
    pieces_.push_back(other);
  }

  Mesh finish() {
    Mesh out;
    out.objects = {{"building", 0, 0}, {"surroundings", 0, -1}};
    std::vector<std::uint32_t> place(corners_.size(), kNoObject);  // of corners that are used
    for (const Piece& piece : pieces_) {
      const std::uint32_t material = mesh_.triangle_material[piece.triangle];
      std::array<std::uint32_t, 3> triangle{};
      std::array<TexturePoint, 3> texture{};
      for (std::size_t k = 0; k < 3; ++k) {
        const Corner& corner = corners_[piece.corners[k]];
        std::uint32_t& at = place[piece.corners[k]];
        if (at == kNoObject) {
          at = static_cast<std::uint32_t>(out.positions.size());
          out.positions.push_back(corner.position);
          out.colours.push_back(shines(mesh_.materials[material]) ? Vec3f{1, 1, 1} : corner.light);
        }
        triangle[k] = at;
        texture[k] = corner.texture;
      }
      out.triangles.push_back(triangle);
      out.triangle_material.push_back(material);
      out.triangle_object.push_back(surroundings_.has(piece.triangle) ? kSurroundings : 0);
      if (!mesh_.texture_points.empty()) out.texture_points.push_back(texture);
    }
    for (const Material& material : mesh_.materials) out.materials.push_back(shown(material));
    return out;
  }

  static bool shines(const Material& material) { return luminance(material.emission) > 0; }

  Material shown(Material material) const {
    constexpr float kMirror = 0.5F;  // from this share on one sees mostly what it reflects
    constexpr Vec3f kReflected{0.45F, 0.47F, 0.5F};
    if (shines(material)) {
      const auto part = [](float x) { return std::clamp(x, 0.0F, 1.0F); };
      const Vec3f glow = light_.exposure * material.emission;
      material.colour = {part(glow.x), part(glow.y), part(glow.z)};
      material.texture = {};
      material.cutout = 0;
    } else if (material.mirror >= kMirror) {
      material.colour = kReflected;
      material.texture = {};
    }
    material.emission = {};
    material.mirror = 0;
    return material;
  }

  const SurfaceLight& light_;
  const Mesh& mesh_;
  const VertexLightOptions& options_;
  Surroundings surroundings_;
  std::vector<Corner> corners_;
  std::vector<Piece> pieces_;
  std::unordered_map<std::uint64_t, Middle> middles_;
};

}  // namespace

Mesh with_vertex_light(const LitMesh& light, const VertexLightOptions& options) {
  const float exposure = image::kMidGrey<float> / light.key();
  const auto at = [&](std::span<const SurfacePoint> points, std::span<Vec3f> found) {
    light.light(points, found);
    for (Vec3f& radiance : found) radiance = exposure * radiance;
  };
  return with_vertex_light(light.mesh(), {at, exposure}, options);
}

Mesh with_vertex_light(const Mesh& mesh, const SurfaceLight& light,
                       const VertexLightOptions& options) {
  check_options(options);
  if (!light.at) throw ArgumentError("light: none");
  return Cutter(mesh, light, options).run();
}

}  // namespace enfilade::mesh
