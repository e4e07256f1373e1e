#include "enfilade/continuous/pixels/tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace enfilade::continuous::pixels {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();

float part(Vec3f v, std::size_t axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

struct Bounds {
  Vec3f low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
  void add(Vec3f p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  void add(const Bounds& b) {
    low = {std::min(low.x, b.low.x), std::min(low.y, b.low.y), std::min(low.z, b.low.z)};
    high = {std::max(high.x, b.high.x), std::max(high.y, b.high.y), std::max(high.z, b.high.z)};
  }
  float half_area() const {
    const Vec3f d = high - low;
    return d.x < 0 ? 0 : d.x * d.y + d.y * d.z + d.z * d.x;
  }
  Vec3f middle() const { return 0.5F * (low + high); }
};

struct Item {
  Bounds box;
  Vec3f middle;
  std::uint32_t triangle;
};

struct Split {
  float cost = kFar;
  std::size_t axis = 0;
  float at = 0;
};

constexpr std::size_t kBins = 16;

// Costs of a leaf are by bundles of 16, as its triangles are worked on at once.
float bundles_of(std::size_t triangles) {
  return static_cast<float>((triangles + Bundle::kSize - 1) / Bundle::kSize);
}

Split best_split(std::span<const Item> items, const Bounds& middles) {
  Split best;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float from = part(middles.low, axis), size = part(middles.high, axis) - from;
    if (!(size > 0)) continue;
    std::array<Bounds, kBins> boxes;
    std::array<std::size_t, kBins> counts{};
    const float scale = kBins / size;
    for (const Item& item : items) {
      const auto bin =
          std::min(static_cast<std::size_t>((part(item.middle, axis) - from) * scale), kBins - 1);
      boxes[bin].add(item.box);
      ++counts[bin];
    }
    std::array<float, kBins> above{};
    Bounds box;
    std::size_t count = 0;
    for (std::size_t k = kBins - 1; k > 0; --k) {
      box.add(boxes[k]);
      count += counts[k];
      above[k] = count == 0 ? kFar : box.half_area() * bundles_of(count);
    }
    box = {};
    count = 0;
    for (std::size_t k = 1; k < kBins; ++k) {
      box.add(boxes[k - 1]);
      count += counts[k - 1];
      if (count == 0) continue;
      const float cost = box.half_area() * bundles_of(count) + above[k];
      if (cost < best.cost) best = {cost, axis, from + static_cast<float>(k) / scale};
    }
  }
  return best;
}

std::size_t longest_axis(const Bounds& box) {
  const Vec3f d = box.high - box.low;
  if (d.x >= d.y && d.x >= d.z) return 0;
  return d.y >= d.z ? 1 : 2;
}

}  // namespace

struct Tree::Builder {
  Tree& tree;
  const mesh::Mesh& mesh;
  std::vector<Item> items;

  void add_items() {
    items.reserve(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      Item item;
      for (const std::uint32_t corner : mesh.triangles[t]) item.box.add(mesh.positions[corner]);
      item.middle = item.box.middle();
      item.triangle = t;
      items.push_back(item);
    }
  }

  bool has_holes(std::uint32_t triangle) const {
    const mesh::Material& material = mesh.materials[mesh.triangle_material[triangle]];
    return material.cutout > 0 && material.texture.channels == 4 && !mesh.texture_points.empty();
  }

  void make_leaf(Node& node, std::span<const Item> of) {
    node.leaf = true;
    node.next = static_cast<std::uint32_t>(tree.bundles.size());
    Bundle bundle{};
    for (std::size_t i = 0; i < of.size(); ++i) {
      bundle.triangle[i] = static_cast<std::int32_t>(of[i].triangle);
      if (has_holes(of[i].triangle)) bundle.holes |= 1U << i;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3f p = mesh.positions[mesh.triangles[of[i].triangle][k]];
        bundle.corner[k][0][i] = p.x;
        bundle.corner[k][1][i] = p.y;
        bundle.corner[k][2][i] = p.z;
      }
    }
    tree.bundles.push_back(bundle);
  }

  // Where the second child's items begin.
  std::size_t part_items(std::size_t first, std::size_t last, const Bounds& middles,
                         std::size_t depth, Node& node) {
    const auto all = std::span(items).subspan(first, last - first);
    // Near the depth that the stack has room for, halves make sure that it is not exceeded.
    constexpr std::size_t kHalvesFrom = kMostDepth - 40;
    Split split;
    if (depth < kHalvesFrom) split = best_split(all, middles);
    if (split.cost < kFar) {
      const auto middle = std::partition(all.begin(), all.end(), [&](const Item& item) {
        return part(item.middle, split.axis) < split.at;
      });
      const auto count = static_cast<std::size_t>(middle - all.begin());
      if (count > 0 && count < all.size()) {
        node.axis = static_cast<std::uint8_t>(split.axis);
        node.split = split.at;
        return first + count;
      }
    }
    const std::size_t axis = longest_axis(middles), half = all.size() / 2;
    std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(half), all.end(),
                     [axis](const Item& a, const Item& b) {
                       const float x = part(a.middle, axis), y = part(b.middle, axis);
                       return x != y ? x < y : a.triangle < b.triangle;
                     });
    node.axis = static_cast<std::uint8_t>(axis);
    node.split = part(all[half].middle, axis);
    return first + half;
  }

  void build() {
    struct Range {
      std::size_t first, last, depth;
      std::uint32_t node;
    };
    std::vector<Range> open{{0, items.size(), 0, 0}};
    tree.nodes.resize(1);
    while (!open.empty()) {
      const Range range = open.back();
      open.pop_back();
      Bounds box, middles;
      for (std::size_t i = range.first; i < range.last; ++i) {
        box.add(items[i].box);
        middles.add(items[i].middle);
      }
      Node node;
      node.middle = box.middle();
      // A little more than half of it, as the middle is rounded.
      const float slack =
          1e-6F * std::max({std::abs(box.low.x), std::abs(box.high.x), std::abs(box.low.y),
                            std::abs(box.high.y), std::abs(box.low.z), std::abs(box.high.z)});
      node.half = 0.5F * (box.high - box.low) + Vec3f{slack, slack, slack};
      const std::size_t count = range.last - range.first;
      if (count <= Bundle::kSize) {
        make_leaf(node, std::span(items).subspan(range.first, count));
      } else {
        const std::size_t middle = part_items(range.first, range.last, middles, range.depth, node);
        node.next = static_cast<std::uint32_t>(tree.nodes.size());
        tree.nodes.resize(tree.nodes.size() + 2);
        open.push_back({range.first, middle, range.depth + 1, node.next});
        open.push_back({middle, range.last, range.depth + 1, node.next + 1});
      }
      tree.nodes[range.node] = node;
    }
  }
};

Tree::Tree(const mesh::Mesh& mesh) {
  Builder builder{*this, mesh, {}};
  builder.add_items();
  builder.build();
}

}  // namespace enfilade::continuous::pixels
