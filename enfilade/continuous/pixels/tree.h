/// \file  A tree of boxes over a mesh's triangles, for drawing from front to back.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "enfilade/mesh/mesh.h"

namespace enfilade::continuous::pixels {

/// Up to 16 triangles, in the layout of vector instructions. Unused ones have all corners at the
/// origin, and so no area.
struct alignas(64) Bundle {
  static constexpr std::size_t kSize = 16;
  /// x, y and z of the three corners, metres.
  std::array<std::array<std::array<float, kSize>, 3>, 3> corner;
  std::array<std::int32_t, kSize> triangle;
  std::uint32_t holes = 0;  ///< bits: triangles whose textures have holes
};

/// A binary tree, the root first. Immutable.
class Tree {
 public:
  struct Node {
    Vec3f middle, half;  ///< of the box
    float split = 0;     ///< where children part, along `axis`
    /// Index of the child below the split, the other follows it; for a leaf, its bundle.
    std::uint32_t next = 0;
    std::uint8_t axis = 0;
    bool leaf = false;
  };

  /// Splits by the surface area heuristic. \pre mesh passes check()
  explicit Tree(const mesh::Mesh& mesh);

  std::vector<Node> nodes;
  std::vector<Bundle> bundles;
  static constexpr std::size_t kMostDepth = 96;

 private:
  struct Builder;
};

}  // namespace enfilade::continuous::pixels
