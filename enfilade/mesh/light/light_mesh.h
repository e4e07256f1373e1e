/// \file  Points on a mesh's surfaces at which light is computed, and the pieces of triangles
/// between which it is interpolated.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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
  struct Piece {
    std::array<LightPoint, 3> front;
    std::uint32_t triangle = 0;
  };
  /// A point of a piece.
  struct Place {
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
  std::span<const Piece> pieces() const noexcept { return pieces_; }
  Place locate(std::uint32_t triangle, float u, float v) const;

  /// Splits all edges for which `wanted(a, b)` (front sides, in any order) holds, until there is
  /// none.
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

  float area(const Piece& piece) const;
  Vec3f centroid(const Piece& piece) const;

 private:
  struct Node {
    std::uint32_t next = 0;  ///< a piece, or the first of two nodes
    std::uint32_t edge = 0;  ///< the one that was cut, from corner `edge` to the next; kWhole
  };
  static constexpr std::uint32_t kWhole = 3;

  template <class Wanted>
  int longest(const Piece& piece, const Wanted& wanted) const {
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
    return best;
  }
  /// The piece keeps corner `edge`; the new one, which it returns, has the edge's other end.
  std::uint32_t halve(std::uint32_t piece, unsigned edge);
  LightPoint point_at(Vec3f position, Vec3f normal);
  void grow_table();

  std::vector<Vec3f> positions_, normals_;  ///< by place; normals are those of even ids
  std::vector<std::array<std::int16_t, 3>> keys_;
  std::vector<std::array<LightPoint, 2>> ends_;  ///< of even ids
  std::vector<std::uint32_t> table_;             ///< open addressing: place + 1
  std::vector<Piece> pieces_;
  std::vector<std::uint32_t> node_of_piece_;
  std::vector<Node> nodes_;  ///< the first ones are the triangles
};

}  // namespace enfilade::mesh::light
