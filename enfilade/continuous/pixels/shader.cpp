// Colours of pixels with vector instructions, once for each instruction set that Highway knows. All
// operations are those of PixelPainter::look(), in its order, and none is fused.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "enfilade/continuous/pixels/shader.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <array>
#include <cstddef>
#include <type_traits>

#include "enfilade/continuous/pixels/instruction_sets.h"
#include "enfilade/continuous/pixels/photo.h"

HWY_BEFORE_NAMESPACE();
namespace enfilade::continuous::pixels {
namespace HWY_NAMESPACE {
#include "enfilade/continuous/pixels/simd_vector.inc"

HWY_INLINE Vector times(Vector a, Vector b) {
  return {hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)};
}
HWY_INLINE VU bits_of(VI v) { return hn::BitCast(DU(), v); }
HWY_INLINE VI signed_of(VU v) { return hn::BitCast(DI(), v); }
HWY_INLINE VF to_number(VU v) { return hn::ConvertTo(DF(), signed_of(v)); }  // below 2^31

// Fields of records, as many numbers of 32 bits from one to the next.
struct Records {
  const float* floats;
  const std::int32_t* integers;
  std::size_t stride;
};
template <class T>
Records records(const T* first) {
  static_assert(std::is_standard_layout_v<T> && sizeof(T) % 4 == 0);
  const void* const at = first;
  return {static_cast<const float*>(at), static_cast<const std::int32_t*>(at), sizeof(T) / 4};
}
// Reads from one record for all lanes, or from one for each.
class Single {
 public:
  Single(const Records& of, std::size_t record) : of_(of), at_(record * of.stride) {}
  HWY_INLINE VF real(std::size_t field) const { return number(of_.floats[at_ + field]); }
  HWY_INLINE VI whole(std::size_t field) const { return number(of_.integers[at_ + field]); }

 private:
  Records of_;
  std::size_t at_;
};
class Each {
 public:
  HWY_INLINE Each(const Records& of, VI record)
      : of_(of), at_(hn::Mul(record, number(static_cast<std::int32_t>(of.stride)))) {}
  HWY_INLINE VF real(std::size_t field) const {
    return hn::GatherIndex(DF(), of_.floats + field, at_);
  }
  HWY_INLINE VI whole(std::size_t field) const {
    return hn::GatherIndex(DI(), of_.integers + field, at_);
  }

 private:
  Records of_;
  VI at_;
};
template <class Fields>
HWY_INLINE Vector vector_at(const Fields& fields, std::size_t field) {
  return {fields.real(field), fields.real(field + 1), fields.real(field + 2)};
}

#define EN_FIELD(record, name) (offsetof(record, name) / 4)

HWY_INLINE VF share(VF weight) {
  return hn::IfThenElseZero(hn::Gt(weight, hn::Zero(DF())), hn::Min(weight, number(1.0F)));
}

HWY_INLINE Vector unpack_light(VI packed) {
  const VU p = bits_of(packed);
  const VU exponent = hn::Add(hn::ShiftRight<27>(p), hn::Set(DU(), 127 - 24));
  const VF scale = hn::BitCast(DF(), hn::ShiftLeft<23>(exponent));
  const VU low = hn::Set(DU(), 511);
  return scaled(scale, {to_number(hn::And(p, low)), to_number(hn::And(hn::ShiftRight<9>(p), low)),
                        to_number(hn::And(hn::ShiftRight<18>(p), low))});
}

struct Place {
  VF u, v;
};

// Bilinear light; `first` is where a surface's values begin.
template <class Fields>
HWY_INLINE Vector light_at(const std::uint32_t* light, const Fields& surface, VI first, Place at) {
  const void* const memory = light;
  const auto* const values = static_cast<const std::int32_t*>(memory);
  const VI white = number(static_cast<std::int32_t>(Surfaces::kWhite));
  if (hn::AllTrue(DI(), hn::Eq(first, white)))
    return unpack_light(number(values[Surfaces::kWhite]));
  static_assert(offsetof(Surface, cells_v) == offsetof(Surface, cells_u) + 2);
  const VU cells = bits_of(surface.whole(EN_FIELD(Surface, cells_u)));
  // One of the two values that all surfaces share has no grid around it.
  const auto own = hn::Gt(first, white);
  const VI one = number(1), zero = hn::Zero(DI());
  const VI cells_u = hn::IfThenElseZero(own, signed_of(hn::And(cells, hn::Set(DU(), 0xFFFFU))));
  const VI cells_v = hn::IfThenElseZero(own, signed_of(hn::ShiftRight<16>(cells)));
  const VF x = hn::Mul(at.u, hn::ConvertTo(DF(), cells_u));
  const VF y = hn::Mul(at.v, hn::ConvertTo(DF(), cells_v));
  const VI i = hn::Min(hn::ConvertTo(DI(), x), hn::Max(hn::Sub(cells_u, one), zero));
  const VI j = hn::Min(hn::ConvertTo(DI(), y), hn::Max(hn::Sub(cells_v, one), zero));
  const VF a = hn::Sub(x, hn::ConvertTo(DF(), i)), b = hn::Sub(y, hn::ConvertTo(DF(), j));
  const VI pitch = hn::Add(cells_u, one);
  const VI low = hn::Add(first, hn::Add(hn::Mul(j, pitch), i));
  const VI high = hn::Add(low, hn::IfThenElseZero(hn::Gt(cells_v, zero), pitch));
  const VI next = hn::IfThenElseZero(hn::Gt(cells_u, zero), one);
  const auto value = [&](VI place) { return unpack_light(hn::GatherIndex(DI(), values, place)); };
  const VF rest_a = hn::Sub(number(1.0F), a), rest_b = hn::Sub(number(1.0F), b);
  const Vector below = scaled(rest_a, value(low)) + scaled(a, value(hn::Add(low, next)));
  const Vector above = scaled(rest_a, value(high)) + scaled(a, value(hn::Add(high, next)));
  return scaled(rest_b, below) + scaled(b, above);
}

// Filtered parts of a texel in 1 / 256 of a byte's step.
struct Parts {
  VU r, g, b;
};

struct Axis {
  VI low, high;
  VU share;  // of 256
};
HWY_INLINE Axis along(VF at, VI size) {
  const VF n = hn::ConvertTo(DF(), size);
  const VF x = hn::Add(hn::Mul(hn::Sub(at, hn::Floor(at)), n), hn::Sub(n, number(0.5F)));
  const VI whole = hn::ConvertTo(DI(), x);
  const VI share =
      hn::ConvertTo(DI(), hn::Mul(hn::Sub(x, hn::ConvertTo(DF(), whole)), number(256.0F)));
  const VI below = hn::Sub(whole, size), last = hn::Sub(size, number(1));
  const auto fits = hn::And(hn::Gt(size, below), hn::Gt(below, number(-1)));
  const VI low = hn::IfThenElse(fits, below, last), next = hn::Add(low, number(1));
  return {low, hn::IfThenElseZero(hn::Gt(size, next), next), bits_of(share)};
}

// Both halves of 32 bits times numbers up to 256, products below 2^16.
HWY_INLINE VU halves_times(VU halves, VU factor) {
#if HWY_TARGET == HWY_SCALAR  // has no vectors of 16-bit numbers
  const VU low = hn::Mul(hn::And(halves, hn::Set(DU(), 0xFFFFU)), factor);
  return hn::Or(low, hn::ShiftLeft<16>(hn::Mul(hn::ShiftRight<16>(halves), factor)));
#else
  const hn::Repartition<std::uint16_t, DU> d16;
  return hn::BitCast(DU(), hn::Mul(hn::BitCast(d16, halves),
                                   hn::BitCast(d16, hn::Or(factor, hn::ShiftLeft<16>(factor)))));
#endif
}

template <class Fields>
HWY_INLINE Parts between(const Textures::Tables& tables, const Fields& fields, VF s, VF t) {
  const VI width = fields.whole(EN_FIELD(Textures::TextureLevel, width));
  const Axis x = along(s, width),
             y = along(t, fields.whole(EN_FIELD(Textures::TextureLevel, height)));
  const VI first = fields.whole(EN_FIELD(Textures::TextureLevel, first));
  const VI top = hn::Add(first, hn::Mul(y.low, width));
  const VI bottom = hn::Add(first, hn::Mul(y.high, width));
  const VU both = hn::ShiftRight<8>(halves_times(x.share, y.share));
  const VU right = hn::Sub(x.share, both), below = hn::Sub(y.share, both);
  const VU rest = hn::Sub(hn::Sub(hn::Set(DU(), 256), x.share), below);
  const VU even = hn::Set(DU(), 0x00FF00FFU);
  VU red_blue = hn::Zero(DU()), green = hn::Zero(DU());
  const auto add = [&](VI row, VI column, VU weight) {
    const void* const memory = tables.texels;
    const VU texel = bits_of(
        hn::GatherIndex(DI(), static_cast<const std::int32_t*>(memory), hn::Add(row, column)));
    red_blue = hn::Add(red_blue, halves_times(hn::And(texel, even), weight));
    green = hn::Add(green, halves_times(hn::And(hn::ShiftRight<8>(texel), even), weight));
  };
  add(top, x.low, rest);
  add(top, x.high, right);
  add(bottom, x.low, below);
  add(bottom, x.high, both);
  const VU low = hn::Set(DU(), 0xFFFFU);
  return {hn::And(red_blue, low), hn::And(green, low), hn::ShiftRight<16>(red_blue)};
}

// Lanes often need the same size of a texture.
HWY_INLINE Parts between(const Textures::Tables& tables, VI level, VF s, VF t) {
  const Records levels = records(tables.levels);
  const std::int32_t first = hn::GetLane(level);
  if (hn::AllTrue(DI(), hn::Eq(level, number(first)))) {
    return between(tables, Single(levels, static_cast<std::size_t>(first)), s, t);
  }
  return between(tables, Each(levels, level), s, t);
}

HWY_INLINE Vector texels(const SceneParts& scene, VI texture, VF s, VF t, VF size) {
  const Textures::Tables tables = scene.surfaces.textures.tables();
  const void* const memory = tables.first_level;
  const VI level = hn::GatherIndex(DI(), static_cast<const std::int32_t*>(memory), texture);
  const Each fields(records(tables.levels), level);
  const VI last = fields.whole(EN_FIELD(Textures::TextureLevel, last));
  const VI logarithm = hn::Sub(hn::BitCast(DI(), size), number(127 << 23));
  const auto small = hn::RebindMask(DI(), hn::Gt(size, number(1.0F)));
  const VI halvings =
      hn::IfThenElseZero(small, hn::Min(hn::ShiftRight<15>(logarithm), hn::ShiftLeft<8>(last)));
  const VI fine = hn::Add(level, hn::ShiftRight<8>(halvings));
  const VI share = hn::And(halvings, number(255));
  Parts parts = between(tables, fine, s, t);
  const auto mixed = hn::Gt(share, hn::Zero(DI()));
  if (!hn::AllFalse(DI(), mixed)) {
    const VI coarse = hn::Add(fine, hn::IfThenElseZero(mixed, number(1)));
    const Parts high = between(tables, coarse, s, t);
    const VU part = bits_of(share), rest = hn::Sub(hn::Set(DU(), 256), part);
    const auto mix = [&](VU a, VU b) {
      return hn::ShiftRight<8>(hn::Add(hn::Mul(a, rest), hn::Mul(b, part)));
    };
    parts = {mix(parts.r, high.r), mix(parts.g, high.g), mix(parts.b, high.b)};
  }
  const float* const linear = scene.linear.table();
  const auto light = [&](VU value) {
    return hn::GatherIndex(DF(), linear, signed_of(hn::ShiftRight<6>(value)));
  };
  return {light(parts.r), light(parts.g), light(parts.b)};
}

HWY_INLINE VU toned(const ToneTable& tone, VF light) {
  const auto seen = hn::Ge(light, number(ToneTable::kLeast));
  const VI bits = hn::BitCast(DI(), hn::Min(light, number(ToneTable::kMost)));
  const VI place = hn::ShiftRight<ToneTable::kDropped>(
      hn::Sub(bits, number(static_cast<std::int32_t>(ToneTable::kLeastBits))));
  const VI safe = hn::IfThenElseZero(hn::RebindMask(DI(), seen), place);
  const void* const memory = tone.table();
  const VI byte = hn::GatherIndex(DI(), static_cast<const std::int32_t*>(memory), safe);
  return bits_of(hn::IfThenElseZero(hn::RebindMask(DI(), seen), byte));
}

struct Rays {
  VI triangle;
  VF nearness;
  Vector towards;
};

template <class OfSurface>
HWY_INLINE VF longer_step(const Eye& eye, const OfSurface& surface, Vector towards, VF across) {
  const Vector normal = vector_at(surface, EN_FIELD(Surface, normal));
  const Vector along_s = vector_at(surface, EN_FIELD(Surface, along_s));
  const Vector along_t = vector_at(surface, EN_FIELD(Surface, along_t));
  const auto square = [&](Vector axis) {
    const Vector step = axis - scaled(hn::Div(dot(axis, normal), across), towards);
    const VF s = dot(along_s, step), t = dot(along_t, step);
    return hn::Add(hn::Mul(s, s), hn::Mul(t, t));
  };
  const VF right = square(splat(eye.right)), down = square(splat(eye.down));
  return hn::Sqrt(hn::IfThenElse(hn::Lt(right, down), down, right));
}

struct Look {
  Vector light;
  MF mirror;
};

template <class OfSurface, class OfPaint>
HWY_INLINE Look look(const TileColours& tile, const OfSurface& surface, const OfPaint& paint,
                     const Rays& lanes) {
  const DF d;
  const Vec3f eye = tile.eye.whole, rest = tile.eye.rest;
  const Vector origin = vector_at(surface, EN_FIELD(Surface, origin));
  const VF distance = hn::Div(number(1.0F), lanes.nearness);
  const Vector start{hn::Add(hn::Sub(number(eye.x), origin.x), number(rest.x)),
                     hn::Add(hn::Sub(number(eye.y), origin.y), number(rest.y)),
                     hn::Add(hn::Sub(number(eye.z), origin.z), number(rest.z))};
  const Vector from = start + scaled(distance, lanes.towards);
  const Place at{share(dot(vector_at(surface, EN_FIELD(Surface, along_u)), from)),
                 share(dot(vector_at(surface, EN_FIELD(Surface, along_v)), from))};
  const VF across = dot(lanes.towards, vector_at(surface, EN_FIELD(Surface, normal)));
  const auto back = hn::RebindMask(DI(), hn::Gt(across, hn::Zero(d)));
  const VI side = hn::IfThenElse(back, surface.whole(EN_FIELD(Surface, back)),
                                 surface.whole(EN_FIELD(Surface, front)));
  const Vector light = light_at(tile.scene.surfaces.light.data(), surface, side, at);
  Vector colour = vector_at(paint, EN_FIELD(Paint, colour));
  const VI texture = paint.whole(EN_FIELD(Paint, texture));
  const auto textured = hn::Gt(texture, number(-1));
  if (!hn::AllFalse(DI(), textured)) {
    const VF spread = hn::Mul(number(tile.spread), distance);
    VF size;
    if (tile.longer_step) {
      size = hn::Mul(spread, longer_step(tile.eye, surface, lanes.towards, across));
    } else {
      const VF length = hn::Sqrt(dot(lanes.towards, lanes.towards));
      const VF slant = hn::Sqrt(hn::Max(hn::Div(hn::Abs(across), length), number(kLeastSlant)));
      size = hn::Mul(hn::Div(hn::Mul(spread, length), slant),
                     surface.real(EN_FIELD(Surface, texels_per_metre)));
    }
    const auto point = [&](std::size_t a, std::size_t u, std::size_t v) {
      return hn::Add(hn::Add(surface.real(a), hn::Mul(at.u, surface.real(u))),
                     hn::Mul(at.v, surface.real(v)));
    };
    const Vector texel =
        texels(tile.scene, hn::IfThenElseZero(textured, texture),
               point(EN_FIELD(Surface, s0), EN_FIELD(Surface, su), EN_FIELD(Surface, sv)),
               point(EN_FIELD(Surface, t0), EN_FIELD(Surface, tu), EN_FIELD(Surface, tv)), size);
    const auto has = hn::RebindMask(d, textured);
    const VF one = number(1.0F);
    colour = times(colour, {hn::IfThenElse(has, texel.x, one), hn::IfThenElse(has, texel.y, one),
                            hn::IfThenElse(has, texel.z, one)});
  }
  const VF gloss = paint.real(EN_FIELD(Paint, gloss));
  colour = colour + Vector{gloss, gloss, gloss};
  return {times(colour, light) + vector_at(paint, EN_FIELD(Paint, emission)),
          hn::Gt(paint.real(EN_FIELD(Paint, mirror)), hn::Zero(d))};
}

HWY_INLINE VF either(MF first, VF a, VF b) { return hn::IfThenElse(first, a, b); }
HWY_INLINE Look either(MF first, const Look& a, const Look& b) {
  return {{either(first, a.light.x, b.light.x), either(first, a.light.y, b.light.y),
           either(first, a.light.z, b.light.z)},
          hn::Or(hn::And(first, a.mirror), hn::AndNot(first, b.mirror))};
}

// The one or two triangles that lanes see.
struct Pair {
  bool all;  // there are no more
  std::size_t first, second;
  MF is_first;
};
// \param triangles  of the lanes  \pre a lane is wanted
HWY_INLINE Pair pair_of(VI seen, MF wanted, const std::int32_t* triangles) {
  const DF d;
  const auto place = [&](MF lanes) {
    return static_cast<std::size_t>(hn::FindFirstTrue(d, lanes));
  };
  const auto sees = [&](std::int32_t triangle) {
    return hn::RebindMask(d, hn::Eq(seen, number(triangle)));
  };
  const std::int32_t first = triangles[place(wanted)];
  const MF is_first = sees(first), others = hn::AndNot(is_first, wanted);
  const bool one = hn::AllFalse(d, others);
  const std::int32_t second = one ? first : triangles[place(others)];
  const bool all = one || hn::AllFalse(d, hn::AndNot(sees(second), others));
  return {all, static_cast<std::size_t>(first), static_cast<std::size_t>(second), is_first};
}

std::uint64_t shade(const TileColours& tile, std::uint32_t* rgba) {
  const DF d;
  const DI di;
  const Records surfaces = records(tile.scene.surfaces.all.data());
  const Records paints = records(tile.scene.surfaces.paints.data());
  std::uint64_t left = 0;
  for (std::size_t k = 0; k < kTilePixels; k += hn::Lanes(d)) {
    const VI seen = hn::LoadU(di, tile.triangle + k);
    MF left_out = hn::RebindMask(d, hn::Lt(seen, hn::Zero(di)));
    std::array<std::uint8_t, 8> bits{};
    if (!hn::AllTrue(d, left_out)) {
      const Rays lanes{
          hn::Max(seen, hn::Zero(di)),
          hn::LoadU(d, tile.nearness + k),
          {hn::Load(d, tile.towards.x.data() + k), hn::Load(d, tile.towards.y.data() + k),
           hn::Load(d, tile.towards.z.data() + k)}};
      const auto of_one = [&](std::size_t triangle) {
        return look(tile, Single(surfaces, triangle),
                    Single(paints, tile.scene.surfaces.all[triangle].paint), lanes);
      };
      const Pair pair = pair_of(seen, hn::Not(left_out), tile.triangle + k);
      const Look look_there = [&] {
        if (!pair.all) {
          const Each surface(surfaces, lanes.triangle);
          return look(tile, surface, Each(paints, surface.whole(EN_FIELD(Surface, paint))), lanes);
        }
        const Look of_first = of_one(pair.first);
        if (pair.first == pair.second) return of_first;
        return either(pair.is_first, of_first, of_one(pair.second));
      }();
      left_out = hn::Or(left_out, look_there.mirror);
      const Vector& light = look_there.light;
      const VU red = toned(tile.scene.tone, light.x), green = toned(tile.scene.tone, light.y);
      const VU blue = toned(tile.scene.tone, light.z);
      hn::StoreU(hn::Or(hn::Or(red, hn::ShiftLeft<8>(green)),
                        hn::Or(hn::ShiftLeft<16>(blue), hn::Set(DU(), 255U << 24U))),
                 DU(), rgba + k);
    }
    hn::StoreMaskBits(d, left_out, bits.data());
    left |= (std::uint64_t{bits[0]} | std::uint64_t{bits[1]} << 8U) << k;
  }
  return left;
}

Shader shader() { return &shade; }

#undef EN_FIELD

}  // namespace HWY_NAMESPACE
}  // namespace enfilade::continuous::pixels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace enfilade::continuous::pixels {
namespace {

HWY_EXPORT(shader);

}  // namespace

const std::vector<Shader>& shader_variants() {
  static const std::vector<Shader> kVariants =
      find_versions<Shader>([](const char*) { return HWY_DYNAMIC_DISPATCH(shader)(); });
  return kVariants;
}

Shader best_shader() { return shader_variants().front(); }

}  // namespace enfilade::continuous::pixels
#endif
