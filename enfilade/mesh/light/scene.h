/// \file  The scene to light. Points on surfaces, and pieces of triangles between which light is
/// interpolated; colours and normals; light sources that are sampled explicitly.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/mesh/detail/textures.h"
#include "enfilade/mesh/lighting.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh::light {

/// One side of a point on a surface; `id ^ 1` is the other side. Corners of triangles with the same
/// position and normal are one point.
using LightPoint = std::uint32_t;

/// Triangles, split repeatedly at midpoints of edges. Whether an edge is split depends on its ends
/// only, so that triangles with a common edge share its points, and light is continuous.
class LightMesh {
 public:
  /// Three places, seen from the front: counter-clockwise.
  struct LightPiece {
    std::array<LightPoint, 3> front;
    std::uint32_t triangle = 0;
  };
  /// A point of a piece.
  struct PiecePoint {
    std::uint32_t piece = 0;
    std::array<float, 3> weights{};  ///< of its corners; their sum is 1
  };

  /// Whole triangles. \pre mesh passes check(), and outlives this
  explicit LightMesh(const Mesh& mesh);

  /// Sides of places; ids are 0 .. size() - 1.
  std::size_t size() const noexcept { return 2 * positions_.size(); }
  Vec3f position(LightPoint p) const { return positions_[p / 2]; }
  /// Points away from the side's surface; length 1.
  Vec3f normal(LightPoint p) const { return p % 2 == 0 ? normals_[p / 2] : -normals_[p / 2]; }
  /// Ends of the edge whose midpoint is `p`. \pre it is not a triangle's corner
  std::array<LightPoint, 2> ends(LightPoint p) const {
    return {ends_[p / 2][0] ^ (p & 1U), ends_[p / 2][1] ^ (p & 1U)};
  }
  std::span<const LightPiece> pieces() const noexcept { return pieces_; }
  PiecePoint locate(std::uint32_t triangle, float u, float v) const;

  /// Splits all edges for which `wanted(a, b)` (front sides, in any order) holds, until there is
  /// none. Pieces without area stay whole: nothing hits them, and their number would have no bound.
  template <class Wanted>
  void cut(const Wanted& wanted) {
    std::vector<std::uint32_t> open(pieces_.size());
    for (std::uint32_t i = 0; i < open.size(); ++i) open[i] = i;
    while (!open.empty()) {
      const std::uint32_t piece = open.back();
      const int edge = longest(pieces_[piece], wanted);
      if (edge < 0) {
        open.pop_back();
      } else {
        open.push_back(halve(piece, static_cast<unsigned>(edge)));
      }
    }
  }

  float area(const LightPiece& piece) const;
  Vec3f centroid(const LightPiece& piece) const;

 private:
  struct PieceNode {
    std::uint32_t next = 0;  ///< a piece, or the first of two nodes
    std::uint32_t edge = 0;  ///< the one that was cut, from corner `edge` to the next; kWhole
  };
  static constexpr std::uint32_t kWhole = 3;

  template <class Wanted>
  int longest(const LightPiece& piece, const Wanted& wanted) const {
    int best = -1;
    float most = 0;
    for (int e = 0; e < 3; ++e) {
      const LightPoint a = piece.front[static_cast<std::size_t>(e)];
      const LightPoint b = piece.front[static_cast<std::size_t>(e + 1) % 3];
      const float size = length(position(a) - position(b));
      if (size > most && wanted(a, b)) {
        best = e;
        most = size;
      }
    }
    return best >= 0 && is_line(piece) ? -1 : best;
  }
  /// Whether the corners are on a line, up to rounding.
  bool is_line(const LightPiece& piece) const;
  /// The piece keeps corner `edge`; the new one, which it returns, has the edge's other end.
  std::uint32_t halve(std::uint32_t piece, unsigned edge);
  LightPoint point_at(Vec3f position, Vec3f normal);
  void grow_table();

  std::vector<Vec3f> positions_, normals_;  ///< by place; normals are those of even ids
  std::vector<std::array<std::int16_t, 3>> keys_;
  std::vector<std::array<LightPoint, 2>> ends_;  ///< of even ids
  std::vector<std::uint32_t> table_;             ///< open addressing: place + 1
  std::vector<LightPiece> pieces_;
  std::vector<std::uint32_t> node_of_piece_;
  std::vector<PieceNode> nodes_;  ///< the first ones are the triangles
};

/// Colours and normals of a mesh's triangles.
class LitSurfaces {
 public:
  /// \pre mesh passes check(), and outlives this
  explicit LitSurfaces(const Mesh& mesh);

  const Material& material(std::uint32_t triangle) const {
    return mesh_.materials[mesh_.triangle_material[triangle]];
  }
  /// Normal of the triangle's plane, on its front; length 1.
  Vec3f normal(std::uint32_t triangle) const { return normals_[triangle]; }
  /// Shading normal, on the front; length 1.
  Vec3f normal(std::uint32_t triangle, float u, float v) const;
  Vec3f position(std::uint32_t triangle, float u, float v) const;
  /// Diffuse reflectance, averaged over about `footprint` metres.
  Vec3f colour(std::uint32_t triangle, float u, float v, float footprint) const;
  /// Mean reflectance of the triangle; mirrors count as white.
  Vec3f mean_colour(std::uint32_t triangle) const;

 private:
  Vec3f vertex_colour(std::uint32_t triangle, float u, float v) const;

  const Mesh& mesh_;
  std::vector<detail::TexturePyramid> textures_;  ///< by material
  std::vector<Vec3f> normals_;
  std::vector<float> texels_per_metre_;  ///< by triangle; empty: no textures
};

/// A surface point that receives light.
struct Receiver {
  Vec3f position, normal;  ///< the normal has length 1
};

/// One light, sampled at a few points. These are the same for all receivers, so that their error is
/// smooth over a surface; random points would give noise.
class LightSource {
 public:
  LightSource(const Lamp& lamp);
  LightSource(const Portal& portal, const Sky& sky);
  /// Emissive triangles. \param radiance emitted on both sides
  LightSource(const Mesh& mesh, std::span<const std::uint32_t> triangles, Vec3f radiance);

  /// Whether it is far enough from a receiver, for its size, to be sampled at a few points. Else
  /// its light is found by rays in all directions. Always true for lamps.
  bool aimed_at(Vec3f from) const;
  /// False if it gives less than `least` irradiance or is behind the receiver.
  bool reaches(const Receiver& receiver, float least) const;

  /// Distance from its bounding sphere; >= 0.
  float distance(Vec3f from) const;

  struct Aim {
    Ray ray;           ///< to one of its points
    Vec3f irradiance;  ///< at the receiver, if the ray is not blocked
  };
  std::size_t points() const noexcept { return points_.size(); }
  /// If the first few samples are all blocked, the others are assumed to be.
  std::size_t first_few() const noexcept { return first_few_; }
  Aim aim(const Receiver& receiver, std::size_t point) const;
  Blockers blockers() const noexcept {
    return kind_ == SourceKind::kLamp ? Blockers::kNotGlowing : Blockers::kAll;
  }
  /// Whether a ray to the sky passes through this portal; false for other kinds.
  bool crossed_by(Vec3f origin, Vec3f direction) const;

 private:
  enum class SourceKind : std::uint8_t { kLamp, kPortal, kGlow };
  struct SourcePoint {
    Vec3f position, normal;
    float area = 0;
  };

  SourceKind kind_;
  Vec3f middle_;
  float radius_ = 0;  ///< of a ball round it all
  Vec3f strength_;    ///< lamp: irradiance at 1 m; glow: radiance
  float most_ = 0;    ///< luminance of irradiance at 1 m, at most
  Portal portal_;
  Sky sky_;
  std::vector<SourcePoint> points_;
  std::size_t first_few_ = 0;
};

}  // namespace enfilade::mesh::light
