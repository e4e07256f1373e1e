// Drawing triangles with vector instructions, once for each instruction set that Highway knows.
// Design: docs/design/eyes.md.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "enfilade/continuous/pixels/rasteriser.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "enfilade/continuous/pixels/instruction_sets.h"
#include "enfilade/continuous/pixels/rasteriser.h"

HWY_BEFORE_NAMESPACE();
namespace enfilade::continuous::pixels {
namespace HWY_NAMESPACE {
#include "enfilade/continuous/pixels/simd_vector.inc"

static_assert(Bundle::kSize == 16);

HWY_INLINE Vector cross(Vector a, Vector b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

// A function of the picture, x a + y b + c, by lane.
struct Lines {
  alignas(64) std::array<float, Bundle::kSize> a, b, c;
  HWY_INLINE void store(std::size_t from, Vector v) {
    const DF d;
    hn::Store(v.x, d, a.data() + from);
    hn::Store(v.y, d, b.data() + from);
    hn::Store(v.z, d, c.data() + from);
  }
};
// Of one triangle. The largest and the smallest value in a box are at its corners, also as they
// are rounded, because each operation keeps the order of its arguments.
struct Line {
  float a, b, c;
  float at(float x, float y) const { return (a * x + b * y) + c; }
};

// Pixels' points from the first to the last column and row.
struct Box {
  float x0, x1, y0, y1;
};
HWY_INLINE float largest(const Line& line, const Box& box) {
  return line.at(line.a > 0 ? box.x1 : box.x0, line.b > 0 ? box.y1 : box.y0);
}
HWY_INLINE float smallest(const Line& line, const Box& box) {
  return line.at(line.a > 0 ? box.x0 : box.x1, line.b > 0 ? box.y0 : box.y1);
}

struct Prepared {
  std::array<Lines, 3> edges;  // >= 0 inside
  Lines nearness;
  alignas(64) std::array<std::int32_t, Bundle::kSize> column0, column1, row0, row1;
  std::uint32_t wanted = 0;  // bits
};

struct Triangle {
  std::array<Line, 3> edges;
  Line nearness;
  std::int32_t number;
  bool holes;
};

class Drawer {
 public:
  Drawer(const RasterView& sight, TileRows rows, VisibilityBuffer& frame)
      : tree_(sight.tree),
        surfaces_(sight.surfaces),
        lattice_(sight.lattice),
        eye_(sight.eye),
        fronts_only_(sight.fronts_only),
        most_nearness_(sight.most_nearness()),
        frame_(frame),
        rows_{rows.begin, std::min(rows.end, sight.lattice.tiles_down)} {
    const float half = 0.5F / lattice_.focal;
    first_row_ = static_cast<std::int32_t>(rows_.begin * kTile);
    last_row_ = static_cast<std::int32_t>(std::min(rows_.end * kTile, lattice_.height)) - 1;
    top_ = lattice_.y[static_cast<std::size_t>(first_row_)] - half;
    bottom_ = lattice_.y[static_cast<std::size_t>(last_row_)] + half;
    planes_ = {eye_.right + lattice_.edge_x * eye_.forward,
               lattice_.edge_x * eye_.forward - eye_.right, eye_.down - top_ * eye_.forward,
               bottom_ * eye_.forward - eye_.down};
    for (std::size_t k = 0; k < 4; ++k) sizes_[k] = sizes(planes_[k]);
    axes_ = {sizes(eye_.right), sizes(eye_.down), sizes(eye_.forward)};
  }

  void draw() {
    std::array<std::uint32_t, Tree::kMostDepth + 2> open;
    std::size_t count = 0;
    open[count++] = 0;
    while (count > 0) {
      const Tree::Node& node = tree_.nodes[open[--count]];
      if (is_hidden(node)) continue;
      if (node.leaf) {
        draw(tree_.bundles[node.next]);
        continue;
      }
      const float at = node.axis == 0 ? eye_.whole.x : node.axis == 1 ? eye_.whole.y : eye_.whole.z;
      const std::uint32_t nearer = at < node.split ? 0 : 1;
      open[count++] = node.next + (1 - nearer);
      open[count++] = node.next + nearer;
    }
  }

 private:
  static Vec3f sizes(Vec3f v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
  static std::uint32_t tile_of(float pixel, std::uint32_t tiles) {
    // Written so that what is not a number becomes 0.
    const float tile = pixel * (1.0F / kTile);
    if (!(tile > 0)) return 0;
    return tile < static_cast<float>(tiles) ? static_cast<std::uint32_t>(tile) : tiles - 1;
  }

  bool is_hidden(const Tree::Node& node) const {
    const Vec3f c = (node.middle - eye_.whole) - eye_.rest;
    const float z = enfilade::dot(c, eye_.forward), size_z = enfilade::dot(axes_[2], node.half);
    if (z + size_z <= 0) return true;
    for (std::size_t k = 0; k < 4; ++k) {
      if (enfilade::dot(c, planes_[k]) + enfilade::dot(sizes_[k], node.half) < 0) return true;
    }
    const float low = z - size_z, high = z + size_z;
    constexpr float kTooNear = 1e-2F;
    if (low < kTooNear) return false;
    const float x = enfilade::dot(c, eye_.right), size_x = enfilade::dot(axes_[0], node.half);
    const float y = enfilade::dot(c, eye_.down), size_y = enfilade::dot(axes_[1], node.half);
    const float to_low = lattice_.focal / low, to_high = lattice_.focal / high;
    const float left = x - size_x, right = x + size_x, top = y - size_y, bottom = y + size_y;
    const float mx = lattice_.centre_x, my = lattice_.centre_y;
    const std::uint32_t x0 =
        tile_of(mx + left * (left < 0 ? to_low : to_high) - 1, lattice_.tiles_across);
    const std::uint32_t x1 =
        tile_of(mx + right * (right < 0 ? to_high : to_low) + 1, lattice_.tiles_across);
    const std::uint32_t y0 = std::max(
        tile_of(my + top * (top < 0 ? to_low : to_high) - 1, lattice_.tiles_down), rows_.begin);
    const std::uint32_t y1 =
        std::min(tile_of(my + bottom * (bottom < 0 ? to_high : to_low) + 1, lattice_.tiles_down),
                 rows_.end - 1);
    // More than what rounding could add to the nearness of a pixel of what is inside.
    constexpr float kMore = 1.0001F;
    return is_full(x0, x1, y0, y1, kMore / low);
  }

  // Whether all of these tiles see something that is nearer.
  bool is_full(std::uint32_t x0, std::uint32_t x1, std::uint32_t y0, std::uint32_t y1,
               float nearness) const {
    constexpr std::uint32_t kFew = 12;
    if ((x1 - x0 + 1) * (y1 - y0 + 1) <= kFew) {
      for (std::uint32_t ty = y0; ty <= y1; ++ty) {
        for (std::uint32_t tx = x0; tx <= x1; ++tx) {
          if (frame_.tile_far[frame_.tile_place(tx, ty)] <= nearness) return false;
        }
      }
      return true;
    }
    for (std::uint32_t by = y0 / kBlock; by <= y1 / kBlock; ++by) {
      for (std::uint32_t bx = x0 / kBlock; bx <= x1 / kBlock; ++bx) {
        if (frame_.block_far[by * frame_.blocks_across() + bx] <= nearness) return false;
      }
    }
    return true;
  }

  void draw(const Bundle& bundle) {
    Prepared prepared;
    prepare(bundle, prepared);
    for (std::uint32_t bits = prepared.wanted; bits != 0; bits &= bits - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(bits));
      const auto line = [i](const Lines& lines) {
        return Line{lines.a[i], lines.b[i], lines.c[i]};
      };
      const Triangle triangle{
          {line(prepared.edges[0]), line(prepared.edges[1]), line(prepared.edges[2])},
          line(prepared.nearness),
          bundle.triangle[i],
          (bundle.holes >> i & 1U) != 0};
      const auto tile = [](std::int32_t pixel) {
        return static_cast<std::uint32_t>(pixel) / kTile;
      };
      draw(triangle, tile(prepared.column0[i]), tile(prepared.column1[i]), tile(prepared.row0[i]),
           tile(prepared.row1[i]));
    }
  }

  HWY_INLINE static VF flipped(VF v, hn::Vec<DI> sign) {
    return hn::BitCast(DF(), hn::Xor(hn::BitCast(DI(), v), sign));
  }
  HWY_INLINE static Vector flipped(Vector v, hn::Vec<DI> sign) {
    return {flipped(v.x, sign), flipped(v.y, sign), flipped(v.z, sign)};
  }

  void prepare(const Bundle& bundle, Prepared& out) const {
    const DF d;
    const DI di;
    const Vector whole = splat(eye_.whole), rest = splat(eye_.rest);
    const Vector right = splat(eye_.right), down = splat(eye_.down), forward = splat(eye_.forward);
    for (std::size_t from = 0; from < Bundle::kSize; from += hn::Lanes(d)) {
      std::array<Vector, 3> v;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector at{hn::Load(d, bundle.corner[k][0].data() + from),
                        hn::Load(d, bundle.corner[k][1].data() + from),
                        hn::Load(d, bundle.corner[k][2].data() + from)};
        const Vector c = (at - whole) - rest;
        v[k] = {dot(c, right), dot(c, down), dot(c, forward)};
      }
      const Vector normal = cross(v[1] - v[0], v[2] - v[0]);
      const VF volume = dot(normal, v[0]);
      const auto sign = hn::And(hn::BitCast(di, volume), hn::Set(di, INT32_MIN));
      const VF inverse = hn::Div(hn::Set(d, 1.0F), flipped(volume, sign));
      const Vector turned = flipped(normal, sign);
      out.nearness.store(from, {hn::Mul(turned.x, inverse), hn::Mul(turned.y, inverse),
                                hn::Mul(turned.z, inverse)});
      for (std::size_t k = 0; k < 3; ++k) {
        const Vector &a = v[(k + 1) % 3], &b = v[(k + 2) % 3];
        out.edges[k].store(from, flipped(cross(a - b, a + b), sign));
      }
      auto solid = hn::Gt(hn::Abs(volume), hn::Zero(d));
      if (fronts_only_) solid = hn::And(solid, hn::Lt(volume, hn::Zero(d)));
      mark(v, solid, from, out);
    }
  }

  // Finds the pixels' box of each triangle, and which triangles have one.
  void mark(const std::array<Vector, 3>& v, hn::Mask<DF> solid, std::size_t from,
            Prepared& out) const {
    const DF d;
    const DI di;
    const VF zero = hn::Zero(d), least = hn::Set(d, kLeastDepth);
    const VF least_z = hn::Min(hn::Min(v[0].z, v[1].z), v[2].z);
    const VF most_z = hn::Max(hn::Max(v[0].z, v[1].z), v[2].z);
    auto seen = hn::And(solid, hn::Gt(most_z, zero));
    seen = hn::And(seen, is_within(v));
    const auto has_place = hn::Ge(least_z, least);
    const VF last_column = hn::Set(d, static_cast<float>(lattice_.width - 1));
    const VF first_row = hn::Set(d, static_cast<float>(first_row_));
    const VF last_row = hn::Set(d, static_cast<float>(last_row_));
    const VF mx = hn::Set(d, lattice_.centre_x), my = hn::Set(d, lattice_.centre_y);
    std::array<VF, 3> px, py;
    for (std::size_t k = 0; k < 3; ++k) {
      const VF scale = hn::Div(hn::Set(d, lattice_.focal), hn::Max(v[k].z, least));
      px[k] = hn::Add(hn::Mul(v[k].x, scale), mx);
      py[k] = hn::Add(hn::Mul(v[k].y, scale), my);
    }
    const VF slack = hn::Set(d, kBoxSlack);
    const auto low = [&](const std::array<VF, 3>& p, VF first) {
      const VF at = hn::Ceil(hn::Sub(hn::Min(hn::Min(p[0], p[1]), p[2]), slack));
      return hn::IfThenElse(has_place, hn::Max(at, first), first);
    };
    const auto high = [&](const std::array<VF, 3>& p, VF last) {
      const VF at = hn::Floor(hn::Add(hn::Max(hn::Max(p[0], p[1]), p[2]), slack));
      return hn::IfThenElse(has_place, hn::Min(at, last), last);
    };
    const VF x0 = low(px, zero), x1 = high(px, last_column);
    const VF y0 = low(py, first_row), y1 = high(py, last_row);
    seen = hn::And(seen, hn::And(hn::Le(x0, x1), hn::Le(y0, y1)));
    hn::Store(hn::ConvertTo(di, x0), di, out.column0.data() + from);
    hn::Store(hn::ConvertTo(di, x1), di, out.column1.data() + from);
    hn::Store(hn::ConvertTo(di, y0), di, out.row0.data() + from);
    hn::Store(hn::ConvertTo(di, y1), di, out.row1.data() + from);
    std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(d, seen, bits.data());
    out.wanted |= (std::uint32_t{bits[0]} | std::uint32_t{bits[1]} << 8U) << from;
  }

  // Not all three corners outside of one of the picture's edges.
  hn::Mask<DF> is_within(const std::array<Vector, 3>& v) const {
    const DF d;
    const auto out = [&](auto outside) {
      return hn::And(hn::And(outside(v[0]), outside(v[1])), outside(v[2]));
    };
    const VF edge = hn::Set(d, lattice_.edge_x), top = hn::Set(d, top_);
    const VF bottom = hn::Set(d, bottom_);
    const auto right = out([&](const Vector& a) { return hn::Gt(a.x, hn::Mul(edge, a.z)); });
    const auto left =
        out([&](const Vector& a) { return hn::Lt(a.x, hn::Neg(hn::Mul(edge, a.z))); });
    const auto above = out([&](const Vector& a) { return hn::Lt(a.y, hn::Mul(top, a.z)); });
    const auto below = out([&](const Vector& a) { return hn::Gt(a.y, hn::Mul(bottom, a.z)); });
    return hn::Not(hn::Or(hn::Or(left, right), hn::Or(above, below)));
  }

  Box box_of(std::uint32_t x0, std::uint32_t x1, std::uint32_t y0, std::uint32_t y1) const {
    return {lattice_.x[std::size_t{x0} * kTile], lattice_.x[std::size_t{x1} * kTile + kTile - 1],
            lattice_.y[std::size_t{y0} * kTile], lattice_.y[std::size_t{y1} * kTile + kTile - 1]};
  }
  static bool misses(const Triangle& t, const Box& box) {
    return largest(t.edges[0], box) < 0 || largest(t.edges[1], box) < 0 ||
           largest(t.edges[2], box) < 0;
  }

  void draw(const Triangle& triangle, std::uint32_t x0, std::uint32_t x1, std::uint32_t y0,
            std::uint32_t y1) {
    constexpr std::uint32_t kFew = 6;
    if ((x1 - x0 + 1) * (y1 - y0 + 1) <= kFew) {
      for (std::uint32_t ty = y0; ty <= y1; ++ty) {
        for (std::uint32_t tx = x0; tx <= x1; ++tx) draw_tile(triangle, tx, ty);
      }
      return;
    }
    for (std::uint32_t by = y0 / kBlock; by <= y1 / kBlock; ++by) {
      const std::uint32_t top = std::max(by * kBlock, y0);
      const std::uint32_t bottom = std::min(by * kBlock + kBlock - 1, y1);
      for (std::uint32_t bx = x0 / kBlock; bx <= x1 / kBlock; ++bx) {
        const std::uint32_t left = std::max(bx * kBlock, x0);
        const std::uint32_t right = std::min(bx * kBlock + kBlock - 1, x1);
        const Box box = box_of(left, right, top, bottom);
        if (misses(triangle, box)) continue;
        const float far = frame_.block_far[by * frame_.blocks_across() + bx];
        if (largest(triangle.nearness, box) < far) continue;
        for (std::uint32_t ty = top; ty <= bottom; ++ty) {
          for (std::uint32_t tx = left; tx <= right; ++tx) draw_tile(triangle, tx, ty);
        }
      }
    }
  }

  void draw_tile(const Triangle& triangle, std::uint32_t tx, std::uint32_t ty) {
    const Box box = box_of(tx, tx, ty, ty);
    if (misses(triangle, box)) return;
    const std::size_t tile = frame_.tile_place(tx, ty);
    const float nearest = largest(triangle.nearness, box);
    if (nearest < frame_.tile_far[tile]) return;
    const bool cut = nearest > most_nearness_;
    const bool covers = smallest(triangle.edges[0], box) >= 0 &&
                        smallest(triangle.edges[1], box) >= 0 &&
                        smallest(triangle.edges[2], box) >= 0;
    const float far = cut              ? draw_pixels<false, true, true>(triangle, tx, ty, tile)
                      : triangle.holes ? draw_pixels<false, true, false>(triangle, tx, ty, tile)
                      : covers         ? draw_pixels<true, false, false>(triangle, tx, ty, tile)
                                       : draw_pixels<false, false, false>(triangle, tx, ty, tile);
    if (far == frame_.tile_far[tile]) return;
    const std::size_t block = tile / kBlockTiles;
    const bool was_least = frame_.tile_far[tile] <= frame_.block_far[block];
    frame_.tile_far[tile] = far;
    if (!was_least) return;
    const auto first = frame_.tile_far.begin() + static_cast<std::ptrdiff_t>(block * kBlockTiles);
    frame_.block_far[block] = *std::min_element(first, first + kBlockTiles);
  }

  HWY_INLINE static VF at(const Line& line, VF x, VF y) {
    const DF d;
    return hn::Add(hn::Add(hn::Mul(hn::Set(d, line.a), x), hn::Mul(hn::Set(d, line.b), y)),
                   hn::Set(d, line.c));
  }

  // \returns the least nearness in the tile
  template <bool kCovers, bool kHoles, bool kCut>
  HWY_INLINE float draw_pixels(const Triangle& t, std::uint32_t tx, std::uint32_t ty,
                               std::size_t tile) {
    const DF d;
    const DI di;
    const float* const xs = lattice_.tile_x[tx].data();
    const float* const ys = lattice_.tile_y[ty].data();
    float* const nearness = frame_.nearness.data() + tile * kTilePixels;
    std::int32_t* const numbers = frame_.triangle.data() + tile * kTilePixels;
    const auto number = hn::Set(di, t.number);
    VF least = hn::Set(d, 3e38F);
    for (std::size_t k = 0; k < kTilePixels; k += hn::Lanes(d)) {
      const VF x = hn::LoadU(d, xs + k), y = hn::LoadU(d, ys + k);
      const VF now = at(t.nearness, x, y), before = hn::LoadU(d, nearness + k);
      const auto seen = hn::LoadU(di, numbers + k);
      auto wins = hn::Or(hn::Gt(now, before),
                         hn::And(hn::Eq(now, before), hn::RebindMask(d, hn::Lt(number, seen))));
      if constexpr (!kCovers) {
        const VF zero = hn::Zero(d);
        const auto inside =
            hn::And(hn::And(hn::Ge(at(t.edges[0], x, y), zero), hn::Ge(at(t.edges[1], x, y), zero)),
                    hn::Ge(at(t.edges[2], x, y), zero));
        wins = hn::And(wins, inside);
      }
      if constexpr (kCut) wins = hn::And(wins, hn::Le(now, hn::Set(d, most_nearness_)));
      if constexpr (kHoles) {
        if (!kCut || t.holes) wins = without_holes(wins, t.number, now, xs + k, ys + k);
      }
      const VF nearer = hn::IfThenElse(wins, now, before);
      hn::StoreU(nearer, d, nearness + k);
      hn::StoreU(hn::IfThenElse(hn::RebindMask(di, wins), number, seen), di, numbers + k);
      least = hn::Min(least, nearer);
    }
    return hn::GetLane(hn::MinOfLanes(d, least));
  }

  hn::Mask<DF> without_holes(hn::Mask<DF> wins, std::int32_t number, VF nearness, const float* xs,
                             const float* ys) const {
    const DF d;
    std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(d, wins, bits.data());
    alignas(64) std::array<float, Bundle::kSize> near;
    hn::Store(nearness, d, near.data());
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) {
      const auto bit = static_cast<std::uint8_t>(1U << i % 8);
      if ((bits[i / 8] & bit) == 0) continue;
      if (!is_there(surfaces_, eye_, static_cast<std::uint32_t>(number), xs[i], ys[i], near[i])) {
        bits[i / 8] = static_cast<std::uint8_t>(bits[i / 8] & ~bit);
      }
    }
    return hn::LoadMaskBits(d, bits.data());
  }

  const Tree& tree_;
  const Surfaces& surfaces_;
  const Lattice& lattice_;
  const Eye& eye_;
  bool fronts_only_;
  float most_nearness_;
  VisibilityBuffer& frame_;
  TileRows rows_;
  std::int32_t first_row_, last_row_;
  float top_, bottom_;           // of the band, as y of the lattice
  std::array<Vec3f, 4> planes_;  // through the eye and the picture's edges, inside positive
  std::array<Vec3f, 4> sizes_;   // of their parts
  std::array<Vec3f, 3> axes_;    // likewise, of right, down, forward
};

void rasterise(const RasterView& sight, TileRows rows, VisibilityBuffer& frame) {
  Drawer(sight, rows, frame).draw();
}
Rasteriser rasteriser() { return &rasterise; }

}  // namespace HWY_NAMESPACE
}  // namespace enfilade::continuous::pixels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace enfilade::continuous::pixels {
namespace {

HWY_EXPORT(rasteriser);

}  // namespace

const std::vector<RasteriserVariant>& rasteriser_variants() {
  static const std::vector<RasteriserVariant> kVariants =
      find_versions<RasteriserVariant>([](const char* name) {
        return RasteriserVariant{.name = name, .draw = HWY_DYNAMIC_DISPATCH(rasteriser)()};
      });
  return kVariants;
}

Rasteriser best_rasteriser() { return rasteriser_variants().front().draw; }

}  // namespace enfilade::continuous::pixels
#endif
