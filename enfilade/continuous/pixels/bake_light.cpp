// Light on a grid of points of each triangle, so that a pixel need not search for it, nor trace a
// ray to the sun.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <tuple>
#include <utility>

#include "enfilade/continuous/pixels/scene_parts.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/tone.h"

namespace enfilade::continuous::pixels {
namespace {

constexpr double kMostValues = 24e6;  // of all surfaces; the spacing grows with larger ones
constexpr std::uint32_t kMostCells = 1023;
constexpr float kOutside = 4;  // times the spacing, off the floor
constexpr std::size_t kSamples = 256;

// The grid of one triangle's light.
class Grid {
 public:
  Grid(const Surface& surface, Vec3f u, Vec3f v)
      : cells_u_(surface.cells_u),
        cells_v_(surface.cells_v),
        inset_(std::min(kInset, 3e-3F / std::max({length(u), length(v), 1e-6F}))) {}

  std::size_t size() const { return (cells_u_ + std::size_t{1}) * (cells_v_ + std::size_t{1}); }
  Weights at(std::size_t k) const {
    return {static_cast<float>(k % (cells_u_ + 1U)) / static_cast<float>(cells_u_),
            static_cast<float>(k / (cells_u_ + 1U)) / static_cast<float>(cells_v_)};
  }
  bool is_inside(std::size_t k) const { return at(k).u + at(k).v <= 1 + 1e-5F; }
  // Whether a cell with a part of the triangle has this point.
  bool is_used(std::size_t k) const {
    const std::size_t i = k % (cells_u_ + 1U), j = k / (cells_u_ + 1U);
    const float u = i == 0 ? 0 : static_cast<float>(i - 1) / static_cast<float>(cells_u_);
    const float v = j == 0 ? 0 : static_cast<float>(j - 1) / static_cast<float>(cells_v_);
    return u + v < 1;
  }
  // The light at a point outside continues that of the three others of its cell, where they are
  // inside.
  bool continues(std::size_t k) const {
    if (is_inside(k)) return false;
    const std::size_t pitch = cells_u_ + 1U;
    return k % pitch > 0 && k >= pitch && is_inside(k - 1) && is_inside(k - pitch);
  }
  std::size_t pitch() const { return cells_u_ + 1U; }

  // Point `part` of four around a grid point, a quarter of a cell away; perhaps beyond the edge
  // opposite corner 0.
  Weights sample(std::size_t k, unsigned part) const {
    Weights w = at(k);
    constexpr float kQuarter = 0.25F;
    w.u += (part % 2 == 0 ? -kQuarter : kQuarter) / static_cast<float>(cells_u_);
    w.v += (part / 2 == 0 ? -kQuarter : kQuarter) / static_cast<float>(cells_v_);
    return {std::max(w.u, 0.0F), std::max(w.v, 0.0F)};
  }
  // Within the triangle, and away from its edges, where other surfaces may stand.
  Weights inset(Weights w) const {
    w = {std::max(w.u, 0.0F), std::max(w.v, 0.0F)};
    if (const float sum = w.u + w.v; sum > 1) w = {w.u / sum, w.v / sum};
    return {w.u + inset_ * (1.0F / 3 - w.u), w.v + inset_ * (1.0F / 3 - w.v)};
  }

 private:
  static constexpr float kInset = 0.02F;
  std::uint32_t cells_u_, cells_v_;
  float inset_;
};

class LightBaker {
 public:
  LightBaker(const mesh::LitMesh& light, const SceneOptions& options, SceneParts& parts)
      : light_(light), mesh_(light.mesh()), surroundings_(mesh_), options_(options), parts_(parts) {
    samples_ = luminance(light.lights().sun.irradiance) > 0 ? 4 : 1;
  }

  void run(const Progress& progress) {
    find_others();
    choose_cells();
    const std::size_t count = parts_.surfaces.all.size();
    constexpr std::size_t kParts = 16;
    for (std::size_t k = 0; k < kParts; ++k) {
      const std::size_t first = count * k / kParts, last = count * (k + 1) / kParts;
      std::vector<std::vector<std::uint32_t>> sides(2 * (last - first));
      parallel_for(last - first, 64, options_.threads, [&](std::size_t a, std::size_t b) {
        for (std::size_t t = a; t < b; ++t) {
          for (const std::size_t side : {0U, 1U}) {
            sides[2 * t + side] = values(static_cast<std::uint32_t>(first + t), side == 1);
          }
        }
      });
      for (std::size_t t = first; t < last; ++t) {
        Surface& surface = parts_.surfaces.all[t];
        surface.front = keep(sides[2 * (t - first)]);
        surface.back = keep(sides[2 * (t - first) + 1]);
      }
      if (progress) progress(k + 1, kParts);
    }
    parts_.surfaces.light.shrink_to_fit();
  }

 private:
  static float luminance(Vec3f c) { return image::luminance(c.x, c.y, c.z); }
  Vec3f corner(std::size_t triangle, unsigned k) const {
    const unsigned first = parts_.surfaces.all[triangle].first_corner;
    return mesh_.positions[mesh_.triangles[triangle][(first + k) % 3U]];
  }
  float spacing(std::size_t triangle, double metres) const {
    return static_cast<float>(metres) * (surroundings_.has(triangle) ? kOutside : 1);
  }
  static std::uint16_t cells(float edge, float spacing) {
    const float count = std::ceil(edge / spacing);
    return static_cast<std::uint16_t>(std::clamp(count, 1.0F, static_cast<float>(kMostCells)));
  }

  void choose_cells() {
    double metres = options_.light_spacing;
    double values = 0;
    for (std::size_t t = 0; t < parts_.surfaces.all.size(); ++t) {
      const Vec3f u = corner(t, 1) - corner(t, 0), v = corner(t, 2) - corner(t, 0);
      const double step = spacing(t, metres);
      values += (length(u) / step + 1) * (length(v) / step + 1);
    }
    if (values > kMostValues) metres *= std::sqrt(values / kMostValues);
    for (std::size_t t = 0; t < parts_.surfaces.all.size(); ++t) {
      Surface& surface = parts_.surfaces.all[t];
      surface.cells_u = cells(length(corner(t, 1) - corner(t, 0)), spacing(t, metres));
      surface.cells_v = cells(length(corner(t, 2) - corner(t, 0)), spacing(t, metres));
    }
  }

  // The other halves of rectangles: triangles with the same longest edge, in the same plane. Points
  // beyond that edge lie on them.
  void find_others() {
    const auto& all = parts_.surfaces.all;
    constexpr std::uint32_t kNone = 0xFFFFFFFFU;
    struct Edge {
      std::array<std::uint32_t, 6> ends;
      std::uint32_t triangle;
    };
    std::vector<Edge> edges;
    edges.reserve(all.size());
    for (std::uint32_t t = 0; t < all.size(); ++t) {
      std::array<Vec3f, 2> ends{corner(t, 1), corner(t, 2)};
      const auto bits = [](Vec3f p) {
        return std::array{std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                          std::bit_cast<std::uint32_t>(p.z)};
      };
      auto a = bits(ends[0]), b = bits(ends[1]);
      if (b < a) std::swap(a, b);
      edges.push_back({{a[0], a[1], a[2], b[0], b[1], b[2]}, t});
    }
    std::ranges::sort(edges, [](const Edge& a, const Edge& b) {
      return std::tie(a.ends, a.triangle) < std::tie(b.ends, b.triangle);
    });
    other_.assign(all.size(), kNone);
    constexpr float kSamePlane = 0.9999F;
    for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
      const std::uint32_t a = edges[k].triangle, b = edges[k + 1].triangle;
      if (edges[k].ends != edges[k + 1].ends || other_[a] != kNone) continue;
      if (std::abs(dot(all[a].normal, all[b].normal)) < kSamePlane) continue;
      // On the other side of the edge, not on top of it.
      const Vec3f beyond = all[b].origin - all[a].origin;
      if (dot(all[a].along_u, beyond) + dot(all[a].along_v, beyond) <= 1) continue;
      other_[a] = b;
      other_[b] = a;
    }
  }
  bool has_other(std::uint32_t triangle) const { return other_[triangle] != 0xFFFFFFFFU; }

  mesh::SurfacePoint point(std::uint32_t triangle, const Grid& grid, Weights w, bool back) const {
    if (w.u + w.v > 1 && has_other(triangle)) {
      const Surface &from = parts_.surfaces.all[triangle],
                    &to = parts_.surfaces.all[other_[triangle]];
      const Vec3f at = w.u * (corner(triangle, 1) - corner(triangle, 0)) +
                       w.v * (corner(triangle, 2) - corner(triangle, 0)) +
                       (from.origin - to.origin);
      w = {dot(to.along_u, at), dot(to.along_v, at)};
      if (dot(from.normal, to.normal) < 0) back = !back;
      triangle = other_[triangle];
    }
    w = grid.inset(w);
    const unsigned first = parts_.surfaces.all[triangle].first_corner;
    std::array<float, 3> weights;
    weights[first] = 1 - w.u - w.v;
    weights[(first + 1U) % 3] = w.u;
    weights[(first + 2U) % 3] = w.v;
    return {triangle, weights[1], weights[2], back};
  }

  // The light on one side; empty: dark.
  std::vector<std::uint32_t> values(std::uint32_t triangle, bool back) const {
    const Surface& surface = parts_.surfaces.all[triangle];
    const Grid grid(surface, corner(triangle, 1) - corner(triangle, 0),
                    corner(triangle, 2) - corner(triangle, 0));
    std::vector<Vec3f> sums(grid.size());
    std::array<mesh::SurfacePoint, kSamples> points;
    std::array<std::size_t, kSamples> of;
    std::array<Vec3f, kSamples> found;
    std::size_t n = 0;
    const auto look = [&] {
      light_.light(std::span(points).first(n), std::span(found).first(n));
      for (std::size_t i = 0; i < n; ++i) sums[of[i]] += found[i];
      n = 0;
    };
    for (std::size_t k = 0; k < grid.size(); ++k) {
      if (!grid.is_used(k) || (!has_other(triangle) && grid.continues(k))) continue;
      for (unsigned part = 0; part < samples_; ++part) {
        const Weights place = samples_ == 1 ? grid.at(k) : grid.sample(k, part);
        points[n] = point(triangle, grid, place, back);
        of[n++] = k;
        if (n == kSamples) look();
      }
    }
    look();
    return packed(grid, triangle, std::move(sums));
  }

  std::vector<std::uint32_t> packed(const Grid& grid, std::uint32_t triangle,
                                    std::vector<Vec3f> sums) const {
    const float scale = parts_.scale / static_cast<float>(samples_);
    float most = 0;
    for (std::size_t k = 0; k < sums.size(); ++k) {
      if (!has_other(triangle) && grid.continues(k)) {
        sums[k] = sums[k - 1] + sums[k - grid.pitch()] - sums[k - grid.pitch() - 1];
      } else {
        sums[k] = scale * sums[k];
        most = std::max(most, luminance(sums[k]));
      }
    }
    constexpr float kDark = 1e-5F;  // below what any curve shows
    if (most < kDark) return {};
    std::vector<std::uint32_t> bits(sums.size());
    for (std::size_t k = 0; k < sums.size(); ++k) {
      bits[k] = pack_light(colour_at(grid.at(k), triangle, sums[k]));
    }
    return bits;
  }

  // Times the mesh's own colours.
  Vec3f colour_at(Weights at, std::uint32_t triangle, Vec3f light) const {
    if (mesh_.colours.empty()) return light;
    const unsigned first = parts_.surfaces.all[triangle].first_corner;
    const auto colour = [&](unsigned k) {
      return mesh_.colours[mesh_.triangles[triangle][(first + k) % 3U]];
    };
    const Vec3f c = (1 - at.u - at.v) * colour(0) + at.u * colour(1) + at.v * colour(2);
    return {c.x * light.x, c.y * light.y, c.z * light.z};
  }

  std::uint32_t keep(const std::vector<std::uint32_t>& values) {
    if (values.empty()) return Surfaces::kDark;
    auto& light = parts_.surfaces.light;
    const auto first = static_cast<std::uint32_t>(light.size());
    light.insert(light.end(), values.begin(), values.end());
    return first;
  }

  const mesh::LitMesh& light_;
  const mesh::Mesh& mesh_;
  mesh::Surroundings surroundings_;
  const SceneOptions& options_;
  SceneParts& parts_;
  std::vector<std::uint32_t> other_;  // by triangle
  unsigned samples_ = 1;
};

}  // namespace

void apply_scale(SceneParts& parts) {
  for (Paint& paint : parts.surfaces.paints) paint.emission = parts.scale * paint.emission;
  parts.sky = {parts.scale * parts.sky.zenith, parts.scale * parts.sky.horizon,
               parts.scale * parts.sky.ground};
}

void bake_light(const mesh::LitMesh& light, const SceneOptions& options, const Progress& progress,
                SceneParts& parts) {
  parts.surfaces.light.resize(2);  // kDark and kWhite
  LightBaker(light, options, parts).run(progress);
}

}  // namespace enfilade::continuous::pixels
