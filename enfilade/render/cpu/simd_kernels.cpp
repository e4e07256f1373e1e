// The kernels once for each instruction set that Highway knows, the best one chosen at run time.
// Design: docs/design/kernels.md.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "enfilade/render/cpu/simd_kernels.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include "enfilade/render/cpu/kernels.h"
#include "enfilade/render/cpu/sampling.h"

HWY_BEFORE_NAMESPACE();
namespace enfilade::render::cpu {
namespace HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128

// A machine with no instruction set that Highway knows.
const Kernels* kernels() { return &scalar_kernels(); }

#else
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::ScalableTag<float>;
using DI = hn::Rebind<std::int32_t, DF>;
using DU = hn::Rebind<std::uint32_t, DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using VU = hn::Vec<DU>;

// Converts numbers from 0 to 2^31 - 256. ConvertTo handles all others too, which costs four
// instructions.
HWY_INLINE VI truncated(VF v) {
#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return VI{_mm512_cvttps_epi32(v.raw)};
#elif HWY_TARGET == HWY_AVX2
  return VI{_mm256_cvttps_epi32(v.raw)};
#elif HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
  return VI{_mm_cvttps_epi32(v.raw)};
#else
  return hn::ConvertTo(DI(), v);
#endif
}

// texel_point() for as many columns as a register holds. Multiplications and additions are
// separate, as a fused one would round differently from the scalar kernel. Lanes beyond the piece's
// end repeat the last column, so that none leaves the face.
void points(const FaceLine& line, std::uint32_t size, Piece piece, Points& out) {
  const DF d;
  const DI di;
  const float half = static_cast<float>(size) * 16384.0F;
  const VF middle = hn::Set(d, half), whole = hn::Set(d, half + half), zero = hn::Zero(d);
  const VF last = hn::Set(d, static_cast<float>(piece.end - 1));
  const VF step = hn::Set(d, static_cast<float>(hn::Lanes(d)));
  VF column =
      hn::Add(hn::ConvertTo(d, hn::Iota(di, 0)), hn::Set(d, static_cast<float>(piece.begin)));
  for (std::size_t k = 0; k < piece.size(); k += hn::Lanes(d)) {
    const VF j = hn::Min(column, last);
    const VF ahead = hn::Add(hn::Set(d, line.d0), hn::Mul(j, hn::Set(d, line.d1)));
    const VF ratio = hn::Div(middle, ahead);
    const VF s = hn::Add(hn::Set(d, line.s0), hn::Mul(j, hn::Set(d, line.s1)));
    const VF t = hn::Add(hn::Set(d, line.t0), hn::Mul(j, hn::Set(d, line.t1)));
    const VF x = hn::Add(hn::Mul(s, ratio), middle), y = hn::Add(hn::Mul(t, ratio), middle);
    hn::Store(truncated(hn::Min(hn::Max(x, zero), whole)), di, out.x.data() + k);
    hn::Store(truncated(hn::Min(hn::Max(y, zero), whole)), di, out.y.data() + k);
    column = hn::Add(column, step);
  }
}

using Offsets = std::array<std::int32_t, kBlock + kSlack>;

// --- colour -------------------------------------------------------------------------------------

// Where the texels of a piece's pixels are, and how to weigh them. Written first, for the whole
// piece, so that the loads that follow need not wait for the arithmetic.
struct Taps {
  alignas(64) Offsets offset;
  alignas(64) std::array<std::uint32_t, kBlock + kSlack> wx, wy;  // twice in each lane
};

HWY_INLINE VU weight_twice(VI fixed) {
  const VU w = hn::And(hn::BitCast(DU(), fixed), hn::Set(DU(), 32767));
  return hn::Or(w, hn::ShiftLeft<16>(w));
}

void find_taps(const Points& points, const Face& face, LinearRange range, std::size_t count,
               Taps& taps) {
  const DI di;
  const DU du;
  const VI stride = hn::Set(di, static_cast<std::int32_t>(face.stride));
  const VI low = hn::Set(di, range.low), high = hn::Set(di, range.high);
  const VI shift = hn::Set(di, kLinearShift);
  for (std::size_t k = 0; k < count; k += hn::Lanes(di)) {
    const VI x = hn::Min(hn::Max(hn::Add(hn::Load(di, points.x.data() + k), shift), low), high);
    const VI y = hn::Min(hn::Max(hn::Add(hn::Load(di, points.y.data() + k), shift), low), high);
    const VI row = hn::Mul(hn::ShiftRight<15>(y), stride);
    hn::Store(hn::Add(row, hn::ShiftLeft<2>(hn::ShiftRight<15>(x))), di, taps.offset.data() + k);
    hn::Store(weight_twice(x), du, taps.wx.data() + k);
    hn::Store(weight_twice(y), du, taps.wy.data() + k);
  }
}

// Two texels lie side by side in 8 bytes: one load a row of texels. Written out pair by pair, as
// gcc 12 emits more shuffles than loads otherwise.
template <std::size_t kPixels>
HWY_INLINE hn::Vec<hn::FixedTag<std::uint64_t, kPixels>> load_pairs(const std::uint8_t* texels,
                                                                    const std::int32_t* offset) {
  if constexpr (kPixels == 1) {
    const hn::Full64<std::uint64_t> d;
    return hn::LoadU(d, reinterpret_cast<const std::uint64_t*>(texels + *offset));
  } else {
    const hn::FixedTag<std::uint64_t, kPixels> d;
    return hn::Combine(d, load_pairs<kPixels / 2>(texels, offset + kPixels / 2),
                       load_pairs<kPixels / 2>(texels, offset));
  }
}

// mix15() of the 16-bit halves of each lane.
HWY_INLINE VU mix(VU a, VU b, VU w) {
  const hn::Repartition<std::int16_t, DU> d16;
  const auto a16 = hn::BitCast(d16, a);
  const auto part = hn::MulFixedPoint15(hn::Sub(hn::BitCast(d16, b), a16), hn::BitCast(d16, w));
  return hn::BitCast(DU(), hn::Add(a16, part));
}

// The four texels around the pixels of a register.
struct Quad {
  VU left_top, right_top, left_bottom, right_bottom;
};

HWY_INLINE void load_row(const std::uint8_t* texels, const std::int32_t* offset, VU& left,
                         VU& right) {
  constexpr std::size_t kHalf = hn::MaxLanes(DU()) / 2;
  const VU low = hn::BitCast(DU(), load_pairs<kHalf>(texels, offset));
  const VU high = hn::BitCast(DU(), load_pairs<kHalf>(texels, offset + kHalf));
  left = hn::ConcatEven(DU(), high, low);
  right = hn::ConcatOdd(DU(), high, low);
}

// Red and blue, or green and alpha, as 64ths of a level in 16-bit halves.
HWY_INLINE VU red_blue(VU rgba) {
  return hn::ShiftLeft<6>(hn::And(rgba, hn::Set(DU(), 0x00FF00FFU)));
}
HWY_INLINE VU green_alpha(VU rgba) {
  return hn::ShiftRight<2>(hn::And(rgba, hn::Set(DU(), 0xFF00FF00U)));
}

template <class Split>
HWY_INLINE VU mix_quad(const Quad& q, VU wx, VU wy, Split split) {
  const VU left = mix(split(q.left_top), split(q.left_bottom), wy);
  const VU right = mix(split(q.right_top), split(q.right_bottom), wy);
  return hn::Add(mix(left, right, wx), hn::Set(DU(), 0x00200020U));
}

void filter(const Face& face, const Taps& taps, std::size_t count, std::uint32_t* out) {
  const DU du;
  const std::uint8_t* top = border_origin(face);
  const std::uint8_t* bottom = top + face.stride;
  for (std::size_t k = 0; k < count; k += hn::Lanes(du)) {
    const VU wx = hn::Load(du, taps.wx.data() + k), wy = hn::Load(du, taps.wy.data() + k);
    Quad quad;
    load_row(top, taps.offset.data() + k, quad.left_top, quad.right_top);
    load_row(bottom, taps.offset.data() + k, quad.left_bottom, quad.right_bottom);
    const VU rb = mix_quad(quad, wx, wy, [](VU v) HWY_ATTR { return red_blue(v); });
    const VU ga = mix_quad(quad, wx, wy, [](VU v) HWY_ATTR { return green_alpha(v); });
    const VU low = hn::And(hn::ShiftRight<6>(rb), hn::Set(du, 0x00FF00FFU));
    const VU high = hn::And(hn::ShiftLeft<2>(ga), hn::Set(du, 0xFF00FF00U));
    hn::StoreU(hn::Or(low, high), du, out + k);
  }
}

void colour(const Points& points, const Face& face, bool clamped, std::size_t count,
            std::uint32_t* out) {
  Taps taps;
  find_taps(points, face, linear_range(face.size, clamped), count, taps);
  filter(face, taps, count, out);
}

// --- nearest ------------------------------------------------------------------------------------

template <class T>
void nearest(const Points& points, const Face& face, std::size_t count, T* out) {
  const DI di;
  alignas(64) Offsets offset;
  const VI stride = hn::Set(di, static_cast<std::int32_t>(face.stride / sizeof(T)));
  const VI last = hn::Set(di, static_cast<std::int32_t>(face.size << 15) - 1);
  for (std::size_t k = 0; k < count; k += hn::Lanes(di)) {
    const VI x = hn::ShiftRight<15>(hn::Min(hn::Load(di, points.x.data() + k), last));
    const VI y = hn::ShiftRight<15>(hn::Min(hn::Load(di, points.y.data() + k), last));
    hn::Store(hn::Add(hn::Mul(y, stride), x), di, offset.data() + k);
  }
  const T* texels = reinterpret_cast<const T*>(face.origin);
#pragma GCC unroll 8
  for (std::size_t k = 0; k < count; ++k) out[k] = texels[offset[k]];
}

// --- packing ------------------------------------------------------------------------------------

// Drops the fourth byte of four pixels at once. The 4 bytes beyond the 12 are overwritten by the
// next four pixels, so the last pixels of the caller's memory are done one by one.
template <bool kSwap>
void pack_three(const std::uint32_t* rgba, std::size_t count, std::uint8_t* out) {
  const hn::Full128<std::uint8_t> d8;
  constexpr std::uint8_t kZ = 0x80;
  alignas(16) static constexpr std::uint8_t kRgb[16] = {0,  1,  2,  4,  5,  6,  8,  9,
                                                        10, 12, 13, 14, kZ, kZ, kZ, kZ};
  alignas(16) static constexpr std::uint8_t kBgr[16] = {2, 1,  0,  6,  5,  4,  10, 9,
                                                        8, 14, 13, 12, kZ, kZ, kZ, kZ};
  const auto order = hn::Load(d8, kSwap ? kBgr : kRgb);
  std::size_t k = 0;
  for (; k + 6 <= count; k += 4) {
    const auto four = hn::LoadU(d8, reinterpret_cast<const std::uint8_t*>(rgba + k));
    hn::StoreU(hn::TableLookupBytesOr0(four, order), d8, out + 3 * k);
  }
  for (; k < count; ++k) {
    for (unsigned c = 0; c < 3; ++c) {
      out[3 * k + c] = static_cast<std::uint8_t>(rgba[k] >> (8 * (kSwap ? 2 - c : c)));
    }
  }
}

HWY_INLINE VF planar(VU rgba, int c, const PlanarScale& scale) {
  const VU shifted = c == 0 ? rgba : c == 1 ? hn::ShiftRight<8>(rgba) : hn::ShiftRight<16>(rgba);
  const VU value = hn::And(shifted, hn::Set(DU(), 0xFFU));
  const VF v = hn::ConvertTo(DF(), hn::BitCast(DI(), value));
  return hn::Add(hn::Mul(v, hn::Set(DF(), scale.factor[static_cast<std::size_t>(c)])),
                 hn::Set(DF(), scale.offset[static_cast<std::size_t>(c)]));
}

void pack_planar32(const std::uint32_t* rgba, std::size_t count, const PlanarScale& scale,
                   std::size_t plane, float* out) {
  const DF d;
  const std::size_t n = hn::Lanes(d), whole = count - count % n;
  for (std::size_t k = 0; k < whole; k += n) {
    const VU pixels = hn::LoadU(DU(), rgba + k);
    for (int c = 0; c < 3; ++c) {
      hn::StoreU(planar(pixels, c, scale), d, out + static_cast<std::size_t>(c) * plane + k);
    }
  }
  if (whole < count) {
    scalar_kernels().pack_planar32(rgba + whole, count - whole, scale, plane, out + whole);
  }
}

void pack_planar16(const std::uint32_t* rgba, std::size_t count, const PlanarScale& scale,
                   std::size_t plane, std::uint16_t* out) {
  std::size_t whole = 0;
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  // Only where the processor converts: Highway's own conversion rounds differently from the scalar
  // kernel.
  const hn::Rebind<hwy::float16_t, DF> d16;
  const std::size_t n = hn::Lanes(DF());
  whole = count - count % n;
  for (std::size_t k = 0; k < whole; k += n) {
    const VU pixels = hn::LoadU(DU(), rgba + k);
    for (int c = 0; c < 3; ++c) {
      auto* place =
          reinterpret_cast<hwy::float16_t*>(out + static_cast<std::size_t>(c) * plane + k);
      hn::StoreU(hn::DemoteTo(d16, planar(pixels, c, scale)), d16, place);
    }
  }
#endif
  if (whole < count) {
    scalar_kernels().pack_planar16(rgba + whole, count - whole, scale, plane, out + whole);
  }
}

void stream(std::byte* out, const std::byte* from, std::size_t bytes) {
  constexpr std::size_t kLine = 64;
  const hn::ScalableTag<std::uint8_t> d;
  // Only whole cache lines can go past the caches.
  const std::size_t head =
      std::min(bytes, (kLine - reinterpret_cast<std::uintptr_t>(out) % kLine) % kLine);
  const std::size_t whole = (bytes - head) / kLine * kLine, tail = bytes - head - whole;
  std::memcpy(out, from, head);
  auto* to = reinterpret_cast<std::uint8_t*>(out + head);
  const auto* source = reinterpret_cast<const std::uint8_t*>(from + head);
  for (std::size_t k = 0; k < whole; k += hn::Lanes(d)) {
    hn::Stream(hn::LoadU(d, source + k), d, to + k);
  }
  std::memcpy(to + whole, source + whole, tail);
}

void stream_end() { hwy::FlushStream(); }

HWY_INLINE VF scaled(const std::uint16_t* units, const float* factor, std::size_t k) {
  const DF d;
  const hn::Rebind<std::uint16_t, DF> d16;
  const VF value = hn::ConvertTo(d, hn::PromoteTo(DI(), hn::LoadU(d16, units + k)));
  return hn::Mul(value, hn::LoadU(d, factor + k));
}

constexpr float kMetresPerUnit = 1.0F / static_cast<float>(scan::kDepthUnitsPerMetre);

HWY_INLINE void store(VF values, float* out) { hn::StoreU(values, DF(), out); }
HWY_INLINE void store(VI values, std::uint16_t* out) {
  const hn::Rebind<std::uint16_t, DF> d16;
  hn::StoreU(hn::DemoteTo(d16, values), d16, out);
}

// Stores value(k) for whole registers from the k-th pixel on; the scalar kernel does the rest.
template <class Value, class Scalar, class T>
void pack_depth(const std::uint16_t* units, const float* factor, std::size_t count, T* out,
                Value value, Scalar scalar) {
  const std::size_t n = hn::Lanes(DF()), whole = count - count % n;
  for (std::size_t k = 0; k < whole; k += n) store(value(k), out + k);
  if (whole < count) scalar(units + whole, factor + whole, count - whole, out + whole);
}

HWY_INLINE VI step257(const std::uint16_t* units, const float* factor, std::size_t k) {
  const DF d;
  const VF steps = hn::Mul(scaled(units, factor, k), hn::Set(d, 1.0F / 257.0F));
  const VI whole = hn::ConvertTo(DI(), hn::Add(steps, hn::Set(d, 0.5F)));
  return hn::Add(hn::ShiftLeft<8>(whole), whole);
}

HWY_INLINE VF metres(VF units) { return hn::Mul(units, hn::Set(DF(), kMetresPerUnit)); }

void pack_metres(const std::uint16_t* units, const float* factor, std::size_t count, float* out) {
  const auto value = [=](std::size_t k) HWY_ATTR { return metres(scaled(units, factor, k)); };
  pack_depth(units, factor, count, out, value, scalar_kernels().pack_metres);
}

void pack_units(const std::uint16_t* units, const float* factor, std::size_t count,
                std::uint16_t* out) {
  const auto value = [=](std::size_t k) HWY_ATTR {
    return hn::ConvertTo(DI(), hn::Add(scaled(units, factor, k), hn::Set(DF(), 0.5F)));
  };
  pack_depth(units, factor, count, out, value, scalar_kernels().pack_units);
}

void pack_legacy_units(const std::uint16_t* units, const float* factor, std::size_t count,
                       std::uint16_t* out) {
  const auto value = [=](std::size_t k) HWY_ATTR { return step257(units, factor, k); };
  pack_depth(units, factor, count, out, value, scalar_kernels().pack_legacy_units);
}

void pack_legacy_metres(const std::uint16_t* units, const float* factor, std::size_t count,
                        float* out) {
  const auto value = [=](std::size_t k) HWY_ATTR {
    return metres(hn::ConvertTo(DF(), step257(units, factor, k)));
  };
  pack_depth(units, factor, count, out, value, scalar_kernels().pack_legacy_metres);
}

const Kernels* kernels() {
  static constexpr Kernels kKernels{
      "",
      points,
      colour,
      nearest<std::uint16_t>,
      nearest<std::uint32_t>,
      pack_three<false>,
      pack_three<true>,
      pack_planar16,
      pack_planar32,
      stream,
      stream_end,
      pack_metres,
      pack_units,
      pack_legacy_units,
      pack_legacy_metres,
  };
  return &kKernels;
}

#endif
}  // namespace HWY_NAMESPACE
}  // namespace enfilade::render::cpu
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "enfilade/render/gl_devices.h"

namespace enfilade::render {
namespace cpu {
namespace {
HWY_EXPORT(kernels);
}  // namespace

const Kernels& simd_kernels() noexcept { return *HWY_DYNAMIC_DISPATCH(kernels)(); }

}  // namespace cpu

std::string cpu_target() {
  // Highway numbers the targets so that the better one has the lower bit.
  const auto best = hwy::SupportedTargets() & HWY_TARGETS;
  return hwy::TargetName(best & -best);
}

}  // namespace enfilade::render
#endif
