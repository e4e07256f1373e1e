// The kernels once for each instruction set that Highway knows, the best one chosen at run time.
// docs/design/kernels.md says how they came to be.
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

// texel_point() for as many columns as a register holds. Multiplications and additions are kept
// apart, as a fused one would round differently from the twin.
class TexelPoints {
 public:
  TexelPoints(const FaceLine& line, const TexelScale& scale, Piece piece)
      : line_(line),
        scale_(scale),
        first_(hn::Add(hn::ConvertTo(DF(), hn::Iota(DI(), 0)),
                       hn::Set(DF(), static_cast<float>(piece.begin)))),
        last_(static_cast<float>(piece.end - 1)) {}

  // From the `k`-th pixel of the piece on, truncated; beyond the end, the last one's again, so that
  // no lane leaves the face.
  HWY_INLINE void at(std::size_t k, VI& x, VI& y) const {
    const DF d;
    const VF j = hn::Min(hn::Add(first_, hn::Set(d, static_cast<float>(k))), hn::Set(d, last_));
    const VF ahead = hn::Add(hn::Set(d, line_.d0), hn::Mul(j, hn::Set(d, line_.d1)));
    const VF ratio = hn::Div(hn::Set(d, scale_.half), ahead);
    const VF s = hn::Add(hn::Set(d, line_.s0), hn::Mul(j, hn::Set(d, line_.s1)));
    const VF t = hn::Add(hn::Set(d, line_.t0), hn::Mul(j, hn::Set(d, line_.t1)));
    x = hn::ConvertTo(DI(), clamped(hn::Add(hn::Mul(s, ratio), hn::Set(d, scale_.middle))));
    y = hn::ConvertTo(DI(), clamped(hn::Add(hn::Mul(t, ratio), hn::Set(d, scale_.middle))));
  }

 private:
  HWY_INLINE VF clamped(VF v) const {
    return hn::Min(hn::Max(v, hn::Set(DF(), scale_.low)), hn::Set(DF(), scale_.high));
  }

  FaceLine line_;
  TexelScale scale_;
  VF first_;
  float last_;
};

using Offsets = std::array<std::int32_t, kBlock + kSlack>;

// --- colour -------------------------------------------------------------------------------------

// Where the texels of a piece's pixels are, and how to weigh them. Written first, for the whole
// piece, so that the loads that follow need not wait for the arithmetic.
struct Taps {
  alignas(64) Offsets offset;
  alignas(64) std::array<std::uint32_t, kBlock + kSlack> wx, wy;  // twice in each lane
  alignas(64) std::array<std::uint64_t, kBlock + kSlack> top, bottom;
};

HWY_INLINE VU weight_twice(VI fixed) {
  const VU w = hn::And(hn::BitCast(DU(), fixed), hn::Set(DU(), 32767));
  return hn::Or(w, hn::ShiftLeft<16>(w));
}

void find_taps(const FaceLine& line, const Face& face, bool clamped, Piece piece, Taps& taps) {
  const DI di;
  const DU du;
  const TexelPoints points(line, linear_scale(face.size, clamped), piece);
  const VI stride = hn::Set(di, static_cast<std::int32_t>(face.stride));
  for (std::size_t k = 0; k < piece.size(); k += hn::Lanes(di)) {
    VI x, y;
    points.at(k, x, y);
    const VI row = hn::Mul(hn::ShiftRight<15>(y), stride);
    hn::Store(hn::Add(row, hn::ShiftLeft<2>(hn::ShiftRight<15>(x))), di, taps.offset.data() + k);
    hn::Store(weight_twice(x), du, taps.wx.data() + k);
    hn::Store(weight_twice(y), du, taps.wy.data() + k);
  }
}

// Two texels lie side by side in 8 bytes: one load a row of texels. In pairs of pixels, said
// outright: left alone, gcc 12 shuffles more than it loads. An odd last pixel's partner is there,
// as offsets are found for whole registers.
void fetch(const Face& face, std::size_t count, Taps& taps) {
  const hn::Full64<std::uint64_t> d64;
  const hn::Full128<std::uint64_t> d128;
  const std::uint8_t* top = border_origin(face);
  const std::uint8_t* bottom = top + face.stride;
  const auto load = [d64](const std::uint8_t* texel) HWY_ATTR {
    return hn::LoadU(d64, reinterpret_cast<const std::uint64_t*>(texel));
  };
  for (std::size_t k = 0; k < count; k += 2) {
    const std::ptrdiff_t a = taps.offset[k], b = taps.offset[k + 1];
    hn::Store(hn::Combine(d128, load(top + b), load(top + a)), d128, taps.top.data() + k);
    hn::Store(hn::Combine(d128, load(bottom + b), load(bottom + a)), d128, taps.bottom.data() + k);
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

HWY_INLINE Quad load_quad(const Taps& taps, std::size_t k) {
  const DU du;
  const auto* top = reinterpret_cast<const std::uint32_t*>(taps.top.data() + k);
  const auto* bottom = reinterpret_cast<const std::uint32_t*>(taps.bottom.data() + k);
  Quad quad;
  hn::LoadInterleaved2(du, top, quad.left_top, quad.right_top);
  hn::LoadInterleaved2(du, bottom, quad.left_bottom, quad.right_bottom);
  return quad;
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

void filter(const Taps& taps, std::size_t count, std::uint32_t* out) {
  const DU du;
  for (std::size_t k = 0; k < count; k += hn::Lanes(du)) {
    const VU wx = hn::Load(du, taps.wx.data() + k), wy = hn::Load(du, taps.wy.data() + k);
    const Quad quad = load_quad(taps, k);
    const VU rb = mix_quad(quad, wx, wy, [](VU v) HWY_ATTR { return red_blue(v); });
    const VU ga = mix_quad(quad, wx, wy, [](VU v) HWY_ATTR { return green_alpha(v); });
    const VU low = hn::And(hn::ShiftRight<6>(rb), hn::Set(du, 0x00FF00FFU));
    const VU high = hn::And(hn::ShiftLeft<2>(ga), hn::Set(du, 0xFF00FF00U));
    hn::StoreU(hn::Or(low, high), du, out + k);
  }
}

void colour(const FaceLine& line, const Face& face, bool clamped, Piece piece, std::uint32_t* out) {
  Taps taps;
  find_taps(line, face, clamped, piece, taps);
  fetch(face, piece.size(), taps);
  filter(taps, piece.size(), out);
}

// --- nearest
// --------------------------------------------------------------------------------------

template <class T>
void nearest(const FaceLine& line, const Face& face, Piece piece, T* out) {
  const DI di;
  alignas(64) Offsets offset;
  const TexelPoints points(line, nearest_scale(face.size), piece);
  const VI stride = hn::Set(di, static_cast<std::int32_t>(face.stride / sizeof(T)));
  for (std::size_t k = 0; k < piece.size(); k += hn::Lanes(di)) {
    VI x, y;
    points.at(k, x, y);
    hn::Store(hn::Add(hn::Mul(y, stride), x), di, offset.data() + k);
  }
  const T* texels = reinterpret_cast<const T*>(face.origin);
  for (std::size_t k = 0; k < piece.size(); ++k) out[k] = texels[offset[k]];
}

// --- packing
// --------------------------------------------------------------------------------------

// Four pixels of 128 bits lose their fourth bytes; the 4 bytes beyond the 12 are overwritten by the
// next four pixels, so the last ones of the caller's memory are done one by one.
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
  // Only where the processor converts: elsewhere Highway's own rounds otherwise than the twin.
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

// Runs `vector(k)` over whole registers, then the twin over the rest.
template <class Vector, class Twin, class T>
void pack_depth(const std::uint16_t* units, const float* factor, std::size_t count, T* out,
                Vector vector, Twin twin) {
  const std::size_t n = hn::Lanes(DF()), whole = count - count % n;
  for (std::size_t k = 0; k < whole; k += n) vector(k);
  if (whole < count) twin(units + whole, factor + whole, count - whole, out + whole);
}

void pack_metres(const std::uint16_t* units, const float* factor, std::size_t count, float* out) {
  pack_depth(
      units, factor, count, out,
      [&](std::size_t k) HWY_ATTR {
        const DF d;
        hn::StoreU(hn::Mul(scaled(units, factor, k), hn::Set(d, kMetresPerUnit)), d, out + k);
      },
      scalar_kernels().pack_metres);
}

void pack_units(const std::uint16_t* units, const float* factor, std::size_t count,
                std::uint16_t* out) {
  pack_depth(
      units, factor, count, out,
      [&](std::size_t k) HWY_ATTR {
        const hn::Rebind<std::uint16_t, DF> d16;
        const VF value = hn::Add(scaled(units, factor, k), hn::Set(DF(), 0.5F));
        hn::StoreU(hn::DemoteTo(d16, hn::ConvertTo(DI(), value)), d16, out + k);
      },
      scalar_kernels().pack_units);
}

HWY_INLINE VI step257(const std::uint16_t* units, const float* factor, std::size_t k) {
  const DF d;
  const VF steps = hn::Mul(scaled(units, factor, k), hn::Set(d, 1.0F / 257.0F));
  const VI whole = hn::ConvertTo(DI(), hn::Add(steps, hn::Set(d, 0.5F)));
  return hn::Add(hn::ShiftLeft<8>(whole), whole);
}

void pack_legacy_units(const std::uint16_t* units, const float* factor, std::size_t count,
                       std::uint16_t* out) {
  pack_depth(
      units, factor, count, out,
      [&](std::size_t k) HWY_ATTR {
        const hn::Rebind<std::uint16_t, DF> d16;
        hn::StoreU(hn::DemoteTo(d16, step257(units, factor, k)), d16, out + k);
      },
      scalar_kernels().pack_legacy_units);
}

void pack_legacy_metres(const std::uint16_t* units, const float* factor, std::size_t count,
                        float* out) {
  pack_depth(
      units, factor, count, out,
      [&](std::size_t k) HWY_ATTR {
        const DF d;
        const VF value = hn::ConvertTo(d, step257(units, factor, k));
        hn::StoreU(hn::Mul(value, hn::Set(d, kMetresPerUnit)), d, out + k);
      },
      scalar_kernels().pack_legacy_metres);
}

const Kernels* kernels() {
  static constexpr Kernels kKernels{
      "",
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
#include <bit>

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
