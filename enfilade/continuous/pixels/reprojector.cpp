// Colours of pixels from panoramas with vector instructions, once for each instruction set that
// Highway knows. All operations are those of plain_kernels.cpp, in its order; none is fused.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "enfilade/continuous/pixels/reprojector.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <array>
#include <cstddef>

#include "enfilade/continuous/pixels/instruction_sets.h"
#include "enfilade/continuous/pixels/photo.h"

HWY_BEFORE_NAMESPACE();
namespace enfilade::continuous::pixels {
namespace HWY_NAMESPACE {
namespace reprojecting {
#include "enfilade/continuous/pixels/simd_vector.inc"

struct OnFace {
  VI face;
  VF across, down, along;
};

HWY_INLINE OnFace on_face(Vector d) {
  const VF least = number(kLeastAlong), zero = hn::Zero(DF());
  const VF x = hn::Max(hn::Abs(d.x), least), y = hn::Max(hn::Abs(d.y), least);
  const VF z = hn::Max(hn::Abs(d.z), least);
  const MF on_y = hn::And(hn::Ge(y, x), hn::Ge(y, z)), on_x = hn::Ge(x, z);
  const VF along = hn::IfThenElse(on_y, y, hn::IfThenElse(on_x, x, z));
  const VF part = hn::IfThenElse(on_y, d.y, hn::IfThenElse(on_x, d.x, d.z));
  const MF negative = hn::Lt(part, zero);
  const VF back_x = hn::Neg(d.x), back_z = hn::Neg(d.z);
  const VF across = hn::IfThenElse(on_y, back_x,
                                   hn::IfThenElse(on_x, hn::IfThenElse(negative, d.z, back_z),
                                                  hn::IfThenElse(negative, back_x, d.x)));
  const VF down = hn::IfThenElse(on_y, hn::IfThenElse(negative, back_z, d.z), d.y);
  const auto choose = [](MF which, VI a, VI b) {
    return hn::IfThenElse(hn::RebindMask(DI(), which), a, b);
  };
  const VI face = choose(
      on_y, choose(negative, number(0), number(5)),
      choose(on_x, choose(negative, number(2), number(4)), choose(negative, number(1), number(3))));
  return {face, hn::Div(across, along), hn::Div(down, along), along};
}

struct Taps {
  VI first, pitch;
  VF right, below;
};
HWY_INLINE Taps taps_of(const OnFace& at, VI size) {
  const VF half = hn::Mul(number(0.5F), hn::ConvertTo(DF(), size));
  const VF middle = hn::Add(half, number(0.5F));
  const VF x = hn::Add(hn::Mul(at.across, half), middle);
  const VF y = hn::Add(hn::Mul(at.down, half), middle);
  const auto whole = [size](VF v) {
    return hn::Min(hn::Max(hn::ConvertTo(DI(), v), hn::Zero(DI())), size);
  };
  const VI i = whole(x), j = whole(y);
  const VI pitch = hn::Add(size, number(2));
  const VI first = hn::Add(hn::Mul(hn::Add(hn::Mul(at.face, pitch), j), pitch), i);
  return {first, pitch, hn::Sub(x, hn::ConvertTo(DF(), i)), hn::Sub(y, hn::ConvertTo(DF(), j))};
}

HWY_INLINE VF bilinear(const Taps& taps, VF a, VF b, VF c, VF d) {
  const VF left = hn::Sub(number(1.0F), taps.right), above = hn::Sub(number(1.0F), taps.below);
  const VF top = hn::Add(hn::Mul(left, a), hn::Mul(taps.right, b));
  const VF bottom = hn::Add(hn::Mul(left, c), hn::Mul(taps.right, d));
  return hn::Add(hn::Mul(above, top), hn::Mul(taps.below, bottom));
}

// The four texels of each lane.
template <class D>
struct Four {
  hn::Vec<D> a, b, c, d;
  HWY_INLINE Four(const hn::TFromD<D>* from, const Taps& taps) {
    const VI one = number(1), below = hn::Add(taps.first, taps.pitch);
    a = hn::GatherIndex(D(), from, taps.first);
    b = hn::GatherIndex(D(), from, hn::Add(taps.first, one));
    c = hn::GatherIndex(D(), from, below);
    d = hn::GatherIndex(D(), from, hn::Add(below, one));
  }
};

struct Blend {
  VF weight;
  Vector colour;
};

HWY_INLINE void add(const Photo& photo, Vector point, Vector from_eye, float spread, MF wanted,
                    Blend& blend) {
  const DF d;
  const Vector way = point - splat(photo.centre);
  const OnFace at = on_face(
      {dot(way, splat(photo.right)), dot(way, splat(photo.down)), dot(way, splat(photo.forward))});
  const auto whole_size = static_cast<std::int32_t>(photo.size);
  const VI size = number(whole_size);
  const Taps fine = taps_of(at, size);
  const Four<DF> near(photo.nearness.data(), fine);
  const VF there = bilinear(fine, near.a, near.b, near.c, near.d);
  const VF expected = hn::Div(number(1.0F), at.along);
  const VF slack = hn::Add(hn::Mul(number(kSamePart), expected), number(kSameNearness));
  const MF sees = hn::And(wanted, hn::Le(hn::Abs(hn::Sub(there, expected)), slack));
  if (hn::AllFalse(d, sees)) return;
  const VF eye_square = dot(from_eye, from_eye), square = dot(way, way);
  const VF cosine = hn::Div(dot(from_eye, way), hn::Sqrt(hn::Mul(eye_square, square)));
  const VF farther = hn::Sqrt(hn::Div(square, eye_square)), one = number(1.0F);
  const VF coarse = hn::Mul(number(kCoarseness), hn::Max(hn::Sub(farther, one), hn::Zero(d)));
  const VF penalty = hn::Add(hn::Add(hn::Sub(one, cosine), coarse), number(kLeastPenalty));
  const VF weight = hn::IfThenElseZero(sees, hn::Div(one, hn::Mul(penalty, penalty)));
  const VF texels =
      hn::Div(number(spread * static_cast<float>(whole_size)), hn::Mul(number(2.0F), farther));
  const auto small = hn::RebindMask(DI(), hn::Gt(texels, one));
  const VI logarithm =
      hn::Add(hn::Sub(hn::BitCast(DI(), texels), number(127 << 23)), number(1 << 22));
  const VI level = hn::IfThenElseZero(
      small,
      hn::Min(hn::ShiftRight<23>(logarithm), number(static_cast<std::int32_t>(photo.levels) - 1)));
  const VI level_size =
      hn::BitCast(DI(), hn::Shr(hn::BitCast(DU(), size), hn::BitCast(DU(), level)));
  Taps taps = taps_of(at, level_size);
  taps.first = hn::Add(taps.first, hn::GatherIndex(DI(), photo.first.data(), level));
  const void* const memory = photo.colours.data();
  const Four<DI> texel(static_cast<const std::int32_t*>(memory), taps);
  const auto mixed = [&](const auto& part) {
    return hn::Mul(weight,
                   bilinear(taps, part(texel.a), part(texel.b), part(texel.c), part(texel.d)));
  };
  const VI byte = number(255);
  const auto red = [&](VI v) { return hn::ConvertTo(DF(), hn::And(v, byte)); };
  const auto green = [&](VI v) { return hn::ConvertTo(DF(), hn::And(hn::ShiftRight<8>(v), byte)); };
  const auto blue = [&](VI v) { return hn::ConvertTo(DF(), hn::And(hn::ShiftRight<16>(v), byte)); };
  blend.weight = hn::Add(blend.weight, weight);
  blend.colour = blend.colour + Vector{mixed(red), mixed(green), mixed(blue)};
}

// Lanes that see a mirror.
HWY_INLINE MF mirrors(const Surfaces& surfaces, VI triangle) {
  static_assert(sizeof(Surface) % 4 == 0 && sizeof(Paint) % 4 == 0);
  const void* const memory = surfaces.all.data();
  const auto* const all = static_cast<const std::int32_t*>(memory);
  const VI paint = hn::GatherIndex(DI(), all + offsetof(Surface, paint) / 4,
                                   hn::Mul(triangle, number(std::int32_t{sizeof(Surface) / 4})));
  const void* const paints = surfaces.paints.data();
  const VF mirror =
      hn::GatherIndex(DF(), static_cast<const float*>(paints) + offsetof(Paint, mirror) / 4,
                      hn::Mul(paint, number(std::int32_t{sizeof(Paint) / 4})));
  return hn::Gt(mirror, hn::Zero(DF()));
}

HWY_INLINE VI byte_of(VF x) { return hn::ConvertTo(DI(), hn::Add(x, number(0.5F))); }

std::uint64_t reproject(const TileColours& tile, std::span<const Photo* const> photos,
                        std::uint32_t* rgba) {
  const DF d;
  const DI di;
  std::uint64_t left = 0;
  const VF zero = hn::Zero(d);
  for (std::size_t k = 0; k < kTilePixels; k += hn::Lanes(d)) {
    const VI triangle = hn::LoadU(di, tile.triangle + k);
    const auto is_sky = hn::Lt(triangle, hn::Zero(di));
    const MF sky = hn::RebindMask(d, is_sky);
    const VF distance = hn::IfThenElse(sky, number(kSkyDistance),
                                       hn::Div(number(1.0F), hn::LoadU(d, tile.nearness + k)));
    const Vector way = scaled(
        distance, {hn::Load(d, tile.towards.x.data() + k), hn::Load(d, tile.towards.y.data() + k),
                   hn::Load(d, tile.towards.z.data() + k)});
    const MF mirror =
        hn::And(hn::Not(sky), mirrors(tile.scene.surfaces, hn::Max(triangle, hn::Zero(di))));
    const Vector point = splat(tile.eye.whole) + way;
    Blend blend{zero, {zero, zero, zero}};
    for (const Photo* photo : photos) {
      add(*photo, point, way, tile.spread, hn::Not(mirror), blend);
    }
    const MF found = hn::Gt(blend.weight, zero);
    const VF total = hn::IfThenElse(found, blend.weight, number(1.0F));
    const VI red = byte_of(hn::Div(blend.colour.x, total));
    const VI green = byte_of(hn::Div(blend.colour.y, total));
    const VI blue = byte_of(hn::Div(blend.colour.z, total));
    const VI packed = hn::Or(hn::Or(red, hn::ShiftLeft<8>(green)),
                             hn::Or(hn::ShiftLeft<16>(blue), number(std::int32_t{-16777216})));
    hn::StoreU(hn::BitCast(DU(), packed), DU(), rgba + k);
    std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(d, hn::Not(found), bits.data());
    left |= (std::uint64_t{bits[0]} | std::uint64_t{bits[1]} << 8U) << k;
  }
  return left;
}

}  // namespace reprojecting

Reprojector reprojector() { return &reprojecting::reproject; }

}  // namespace HWY_NAMESPACE
}  // namespace enfilade::continuous::pixels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace enfilade::continuous::pixels {
namespace {

HWY_EXPORT(reprojector);

}  // namespace

const std::vector<Reprojector>& reprojector_variants() {
  static const std::vector<Reprojector> kVariants =
      find_versions<Reprojector>([](const char*) { return HWY_DYNAMIC_DISPATCH(reprojector)(); });
  return kVariants;
}

Reprojector best_reprojector() { return reprojector_variants().front(); }

}  // namespace enfilade::continuous::pixels
#endif
