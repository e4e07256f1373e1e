// The kernels once for each instruction set that Highway knows, the best one chosen at run time.
// Design: docs/design/kernels.md.
// Highway leaves VNNI and VBMI out otherwise.
#define HWY_WANT_AVX3_DL 1
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "enfilade/render/cpu/simd_kernels.cpp"
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include "enfilade/core/errors.h"
#include "enfilade/render/cpu/kernels.h"
#include "enfilade/render/cpu/sampling.h"

#undef EN_X86_512
#undef EN_X86_DL
#undef EN_HALVES
HWY_BEFORE_NAMESPACE();
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3_DL && HWY_COMPILER_GCC_ACTUAL
// Highway 1.0 asks for VNNI when it chooses this target, but does not tell the compiler.
#pragma GCC target("avx512vnni")
#endif
namespace enfilade::render::cpu {
namespace HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128

// A machine with no instruction set that Highway knows.
const Kernels* kernels(bool /*gathers*/) { return &scalar_kernels(); }

#else
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::ScalableTag<float>;
using DI = hn::Rebind<std::int32_t, DF>;
using DU = hn::Rebind<std::uint32_t, DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using VU = hn::Vec<DU>;

// AVX-512: Highway's targets from HWY_AVX3 on, the better ones have lower numbers.
#define EN_X86_512 (HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3)
// Where the processor converts to half precision: Highway's own conversion rounds differently from
// the scalar kernel.
#define EN_HALVES (EN_X86_512 || HWY_TARGET == HWY_AVX2)
// With VNNI and VBMI.
#define EN_X86_DL (HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3_DL)

// Converts numbers from 0 to 2^31 - 256. ConvertTo handles all others too, which costs four
// instructions.
HWY_INLINE VI truncated(VF v) {
#if EN_X86_512
  return VI{_mm512_cvttps_epi32(v.raw)};
#elif HWY_TARGET == HWY_AVX2
  return VI{_mm256_cvttps_epi32(v.raw)};
#elif HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
  return VI{_mm_cvttps_epi32(v.raw)};
#else
  return hn::ConvertTo(DI(), v);
#endif
}

using DI16 = hn::Repartition<std::int16_t, DI>;
using DU16 = hn::Repartition<std::uint16_t, DI>;
using DI8 = hn::Repartition<std::int8_t, DI>;
using DU8 = hn::Repartition<std::uint8_t, DI>;
using DU64 = hn::Repartition<std::uint64_t, DI>;
using VI16 = hn::Vec<DI16>;
using VU64 = hn::Vec<DU64>;

constexpr std::int32_t halves(std::int32_t high, std::int32_t low) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(high) << 16 |
                                   (static_cast<std::uint32_t>(low) & 0xFFFFU));
}

// sum + a.low * b.low + a.high * b.high of the 16-bit halves of each lane, which have signs.
HWY_INLINE VI add_products(VI sum, VI a, VI b) {
#if EN_X86_DL
  return VI{_mm512_dpwssd_epi32(sum.raw, a.raw, b.raw)};
#elif EN_X86_512
  return VI{_mm512_add_epi32(sum.raw, _mm512_madd_epi16(a.raw, b.raw))};
#elif HWY_TARGET == HWY_AVX2
  return VI{_mm256_add_epi32(sum.raw, _mm256_madd_epi16(a.raw, b.raw))};
#elif HWY_ARCH_X86
  return VI{_mm_add_epi32(sum.raw, _mm_madd_epi16(a.raw, b.raw))};
#else
  const VI low =
      hn::Mul(hn::ShiftRight<16>(hn::ShiftLeft<16>(a)), hn::ShiftRight<16>(hn::ShiftLeft<16>(b)));
  return hn::Add(sum, hn::Add(low, hn::Mul(hn::ShiftRight<16>(a), hn::ShiftRight<16>(b))));
#endif
}

// The upper 16 bits of the products of 16-bit halves without signs.
HWY_INLINE VI upper_products(VI a, std::int32_t b) {
  return hn::BitCast(DI(),
                     hn::MulHigh(hn::BitCast(DU16(), a), hn::BitCast(DU16(), hn::Set(DI(), b))));
}

HWY_INLINE VI scale15(VI a, std::int32_t b) {
  return hn::BitCast(
      DI(), hn::MulFixedPoint15(hn::BitCast(DI16(), a), hn::BitCast(DI16(), hn::Set(DI(), b))));
}

// --- where pixels meet faces ---------------------------------------------------------------------

// texel_point() for as many columns as a register holds. Multiplications and additions are
// separate, as a fused one would round differently from the scalar kernel.
struct PointMaker {
  HWY_INLINE PointMaker(const FaceLine& line, Piece piece)
      : x0(hn::Set(DF(), line.x0)),
        x1(hn::Set(DF(), line.x1)),
        y0(hn::Set(DF(), line.y0)),
        y1(hn::Set(DF(), line.y1)),
        d0(hn::Set(DF(), line.d0)),
        d1(hn::Set(DF(), line.d1)),
        one(hn::Set(DF(), 1.0F)),
        last(hn::Set(DF(), static_cast<float>(piece.end - 1))),
        step(hn::Set(DF(), static_cast<float>(hn::Lanes(DF())))),
        column(hn::Add(hn::ConvertTo(DF(), hn::Iota(DI(), 0)),
                       hn::Set(DF(), static_cast<float>(piece.begin)))) {}

  HWY_INLINE void next(VI& x, VI& y) {
    // Lanes beyond the piece's end repeat the last column, so that none leaves the face.
    const VF j = hn::Min(column, last);
    const VF inverse = hn::Div(one, hn::Add(d0, hn::Mul(j, d1)));
    x = truncated(hn::Mul(hn::Add(x0, hn::Mul(j, x1)), inverse));
    y = truncated(hn::Mul(hn::Add(y0, hn::Mul(j, y1)), inverse));
    column = hn::Add(column, step);
  }

  VF x0, x1, y0, y1, d0, d1, one, last, step, column;
};

// tap_at(); docs/design/kernels.md has the formulas.
template <bool kClamped>
struct TapMaker {
  HWY_INLINE explicit TapMaker(const ColourFace& face)
      : first(hn::Set(DI(), face.first)),
        strip_step(hn::Set(DI(), cpu::strip_step(face.size))),
        low(hn::Set(DI(), 65536)),
        high(hn::Set(DI(), static_cast<std::int32_t>(face.size << 16))) {}

  HWY_INLINE void make(VI x, VI y, VI& offset, VI& weights) const {
    if constexpr (kClamped) {
      x = hn::Min(hn::Max(x, low), high);
      y = hn::Min(hn::Max(y, low), high);
    }
    const VI strip = hn::ShiftRight<16>(upper_products(x, halves(kStripFactor, 0)));
    const VI row = add_products(first, x, hn::Set(DI(), halves(3, 0)));
    const VI place = add_products(row, y, hn::Set(DI(), halves(64, 0)));
    offset = hn::Add(place, hn::Mul(strip, strip_step));
    const VI right = upper_products(x, halves(0, 256));
    const VI across = add_products(hn::Set(DI(), 255), right, hn::Set(DI(), halves(0, 255)));
    const VI below = hn::And(hn::ShiftLeft<15>(y), hn::Set(DI(), 0x7FFF0000));
    weights = hn::Or(across, scale15(below, halves(kWholeWeight, 0)));
  }

  VI first, strip_step, low, high;
};

void points(const FaceLine& line, Piece piece, std::size_t at, Points& out) {
  PointMaker maker(line, piece);
  for (std::size_t k = at; k < at + piece.size(); k += hn::Lanes(DI())) {
    VI x, y;
    maker.next(x, y);
    hn::StoreU(x, DI(), out.x.data() + k);
    hn::StoreU(y, DI(), out.y.data() + k);
  }
}

template <bool kClamped, bool kPoints>
void make_taps(const FaceLine& line, Piece piece, const ColourFace& face, std::size_t at, Taps& out,
               Points* points) {
  PointMaker maker(line, piece);
  const TapMaker<kClamped> taps(face);
  for (std::size_t k = at; k < at + piece.size(); k += hn::Lanes(DI())) {
    VI x, y, offset, weights;
    maker.next(x, y);
    taps.make(x, y, offset, weights);
    hn::StoreU(offset, DI(), out.offset.data() + k);
    hn::StoreU(hn::BitCast(DU(), weights), DU(), out.weights.data() + k);
    if constexpr (kPoints) {
      hn::StoreU(x, DI(), points->x.data() + k);
      hn::StoreU(y, DI(), points->y.data() + k);
    }
    // These texels are read when this row is drawn, after the next one is prepared.
    hwy::Prefetch(face.base + out.offset[k]);
  }
}

void taps(const FaceLine& line, Piece piece, const ColourFace& face, std::size_t at, Taps& out) {
  if (face.clamped) return make_taps<true, false>(line, piece, face, at, out, nullptr);
  make_taps<false, false>(line, piece, face, at, out, nullptr);
}

void taps_and_points(const FaceLine& line, Piece piece, const ColourFace& face, std::size_t at,
                     Taps& out, Points& points) {
  if (face.clamped) return make_taps<true, true>(line, piece, face, at, out, &points);
  make_taps<false, true>(line, piece, face, at, out, &points);
}

// --- colour -------------------------------------------------------------------------------------

// Two neighbouring texels are 6 bytes of one cell: a load of 8 has both. Written out pair by pair,
// as gcc 12 emits more shuffles than loads otherwise.
template <std::size_t kPixels>
HWY_INLINE hn::Vec<hn::FixedTag<std::uint64_t, kPixels>> load_pairs(const std::uint8_t* base,
                                                                    const std::int32_t* offset) {
  if constexpr (kPixels == 1) {
    const hn::Full64<std::uint64_t> d;
    return hn::LoadU(d, reinterpret_cast<const std::uint64_t*>(base + *offset));
  } else {
    const hn::FixedTag<std::uint64_t, kPixels> d;
    return hn::Combine(d, load_pairs<kPixels / 2>(base, offset + kPixels / 2),
                       load_pairs<kPixels / 2>(base, offset));
  }
}

constexpr std::size_t kHalf = hn::MaxLanes(DU64());  // pixels of which a register has the pairs

template <bool kGather>
HWY_INLINE VU64 pairs(const std::uint8_t* base, const std::int32_t* offset) {
#if EN_X86_512
  if constexpr (kGather) {
    const __m256i at = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(offset));
    // The zeroes break a dependency on what the register held before.
    return VU64{_mm512_mask_i32gather_epi64(_mm512_setzero_si512(), 0xFF, at, base, 1)};
  }
#elif HWY_TARGET == HWY_AVX2
  if constexpr (kGather) {
    const __m128i at = _mm_loadu_si128(reinterpret_cast<const __m128i*>(offset));
    return VU64{_mm256_mask_i32gather_epi64(_mm256_setzero_si256(),
                                            reinterpret_cast<const long long*>(base), at,
                                            _mm256_set1_epi64x(-1), 1)};
  }
#endif
  return load_pairs<kHalf>(base, offset);
}

// Of each pair of bytes: left * weight of the left + right * weight of the right.
HWY_INLINE VI16 mix_across(hn::Vec<DU8> weights, hn::Vec<DU8> texels) {
#if EN_X86_512
  return VI16{_mm512_maddubs_epi16(weights.raw, texels.raw)};
#elif HWY_TARGET == HWY_AVX2
  return VI16{_mm256_maddubs_epi16(weights.raw, texels.raw)};
#elif HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
  return VI16{_mm_maddubs_epi16(weights.raw, texels.raw)};
#else
  const VI16 w = hn::BitCast(DI16(), weights), t = hn::BitCast(DI16(), texels);
  const VI16 left =
      hn::Mul(hn::And(w, hn::Set(DI16(), 255)), hn::ShiftRight<8>(hn::ShiftLeft<8>(t)));
  const VI16 right =
      hn::Mul(hn::BitCast(DI16(), hn::ShiftRight<8>(hn::BitCast(DU16(), w))), hn::ShiftRight<8>(t));
  return hn::Add(left, right);
#endif
}

// The weights of the pixels of a register of pairs, once for each of their values.
struct Weights {
  hn::Vec<DU8> across;
  VI16 below;
};

// The texels and weights of the pixels of one register of pairs: four 16-bit values a pixel, red,
// green, blue and 0, less 128.
HWY_INLINE VI16 mix(VU64 top, VU64 bottom, const Weights& weights) {
  const DU8 d8;
  // Left and right red, green, blue, nothing.
  constexpr std::uint8_t kZ = 0x80;
  alignas(16) static constexpr std::uint8_t kOrder[16] = {0, 3,  1, 4,  2,  5,  kZ, kZ,
                                                          8, 11, 9, 12, 10, 13, kZ, kZ};
  const auto order = hn::LoadDup128(d8, kOrder);
  const VI16 a = mix_across(weights.across, hn::TableLookupBytesOr0(hn::BitCast(d8, top), order));
  const VI16 b =
      mix_across(weights.across, hn::TableLookupBytesOr0(hn::BitCast(d8, bottom), order));
  const VI16 above =
      hn::Sub(hn::Set(DI16(), static_cast<std::int16_t>(kWholeWeight)), weights.below);
  const VI16 sum = hn::Add(hn::MulFixedPoint15(a, above), hn::MulFixedPoint15(b, weights.below));
  return hn::MulFixedPoint15(sum, hn::Set(DI16(), 256));
}

// Of the first and of the second half of a register's pixels. (Made in one go: a constructor
// without arguments would be compiled for no instruction set, and could not call NEON's.)
struct BothWeights {
  Weights first, second;
};
HWY_INLINE BothWeights load_weights(const std::uint32_t* weights) {
#if EN_X86_DL
  const __m512i all = _mm512_loadu_si512(weights);
  // For each of a pixel's four values its bytes 0 and 1, or 2 and 3.
  alignas(64) static constexpr auto kAcross = [] {
    std::array<std::uint8_t, 64> bytes{};
    for (std::size_t k = 0; k < 64; ++k) bytes[k] = static_cast<std::uint8_t>(k / 8 * 4 + k % 2);
    return bytes;
  }();
  const __m512i across = _mm512_load_si512(kAcross.data());
  const __m512i below = _mm512_add_epi8(across, _mm512_set1_epi8(2));
  const __m512i half = _mm512_set1_epi8(32);
  return {{hn::Vec<DU8>{_mm512_permutexvar_epi8(across, all)},
           VI16{_mm512_permutexvar_epi8(below, all)}},
          {hn::Vec<DU8>{_mm512_permutexvar_epi8(_mm512_add_epi8(across, half), all)},
           VI16{_mm512_permutexvar_epi8(_mm512_add_epi8(below, half), all)}}};
#else
  const DU8 d8;
  alignas(16) static constexpr std::uint8_t kAcross[16] = {0, 1, 0, 1, 0, 1, 0, 1,
                                                           8, 9, 8, 9, 8, 9, 8, 9};
  alignas(16) static constexpr std::uint8_t kBelow[16] = {2,  3,  2,  3,  2,  3,  2,  3,
                                                          10, 11, 10, 11, 10, 11, 10, 11};
  const auto spread = [&](const std::uint32_t* from) HWY_ATTR {
    const hn::Rebind<std::uint32_t, DU64> half;
    const auto wide = hn::BitCast(d8, hn::PromoteTo(DU64(), hn::LoadU(half, from)));
    return Weights{hn::TableLookupBytes(wide, hn::LoadDup128(d8, kAcross)),
                   hn::BitCast(DI16(), hn::TableLookupBytes(wide, hn::LoadDup128(d8, kBelow)))};
  };
  return {spread(weights), spread(weights + kHalf)};
#endif
}

// Values of the first and the second half of a register's pixels to bytes, with the 128 added that
// texels lack, and A = 255; each 16 bytes have two pixels of the first half, then two of the
// second.
HWY_INLINE VU interleaved_rgba(VI16 first, VI16 second) {
#if EN_X86_512
  const VU pixels{_mm512_packs_epi16(first.raw, second.raw)};
#elif HWY_TARGET == HWY_AVX2
  const VU pixels{_mm256_packs_epi16(first.raw, second.raw)};
#else
  const hn::Half<DI8> half;
  const VU pixels =
      hn::BitCast(DU(), hn::Combine(DI8(), hn::DemoteTo(half, second), hn::DemoteTo(half, first)));
#endif
  return hn::Xor(pixels, hn::Set(DU(), 0xFF808080U));
}

#if EN_X86_DL
// Where interleaved_rgba() has pixel p of 16: those of the second half are two places behind their
// likes of the first, in each four.
constexpr std::size_t place_of(std::size_t p) { return p % 8 / 2 * 4 + p % 2 + (p < 8 ? 0 : 2); }
#endif

// In the order of pixels.
HWY_INLINE VU in_order(VU pixels) {
#if EN_X86_512
  return VU{_mm512_permutexvar_epi64(_mm512_setr_epi64(0, 2, 4, 6, 1, 3, 5, 7), pixels.raw)};
#elif HWY_TARGET == HWY_AVX2
  return VU{_mm256_permute4x64_epi64(pixels.raw, 0xD8)};
#else
  return pixels;  // of 16 bytes
#endif
}

// Hands the pixels of a run, a register at a time, to store(interleaved pixels, first pixel).
template <bool kGather, class Store>
HWY_INLINE void draw(const TapRun& run, const Store& store) {
  const std::int32_t* offset = run.taps.offset.data() + run.from;
  const std::uint32_t* weight = run.taps.weights.data() + run.from;
  const std::uint8_t* top = run.base;
  const std::uint8_t* bottom = run.base + image::kCellBytes;
  for (std::size_t k = 0; k < run.count; k += 2 * kHalf) {
    const VU64 top1 = pairs<kGather>(top, offset + k);
    const VU64 bottom1 = pairs<kGather>(bottom, offset + k);
    const VU64 top2 = pairs<kGather>(top, offset + k + kHalf);
    const VU64 bottom2 = pairs<kGather>(bottom, offset + k + kHalf);
    const BothWeights weights = load_weights(weight + k);
    store(interleaved_rgba(mix(top1, bottom1, weights.first), mix(top2, bottom2, weights.second)),
          k);
  }
}

// The three bytes of each of a register's pixels, one after the other, in its lower three quarters.
template <bool kSwap>
HWY_INLINE hn::Vec<DU8> three_bytes(VU interleaved) {
#if EN_X86_DL
  alignas(64) static constexpr auto kOrder = [] {
    std::array<std::uint8_t, 64> order{};
    for (std::size_t p = 0; p < 16; ++p) {
      for (std::size_t c = 0; c < 3; ++c) {
        order[3 * p + c] = static_cast<std::uint8_t>(4 * place_of(p) + (kSwap ? 2 - c : c));
      }
    }
    return order;
  }();
  return hn::Vec<DU8>{_mm512_permutexvar_epi8(_mm512_load_si512(kOrder.data()), interleaved.raw)};
#else
  const DU8 d8;
  constexpr std::uint8_t kZ = 0x80;
  alignas(16) static constexpr std::uint8_t kRgb[16] = {0,  1,  2,  4,  5,  6,  8,  9,
                                                        10, 12, 13, 14, kZ, kZ, kZ, kZ};
  alignas(16) static constexpr std::uint8_t kBgr[16] = {2, 1,  0,  6,  5,  4,  10, 9,
                                                        8, 14, 13, 12, kZ, kZ, kZ, kZ};
  const auto bytes = hn::TableLookupBytesOr0(hn::BitCast(d8, in_order(interleaved)),
                                             hn::LoadDup128(d8, kSwap ? kBgr : kRgb));
#if EN_X86_512
  const __m512i places = _mm512_setr_epi32(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 3, 7, 11, 15);
  return hn::Vec<DU8>{_mm512_permutexvar_epi32(places, bytes.raw)};
#elif HWY_TARGET == HWY_AVX2
  const __m256i places = _mm256_setr_epi32(0, 1, 2, 4, 5, 6, 3, 7);
  return hn::Vec<DU8>{_mm256_permutevar8x32_epi32(bytes.raw, places)};
#else
  return bytes;
#endif
#endif
}

template <bool kGather, bool kSwap>
void draw_three(const TapRun& run, std::uint8_t* out) {
  constexpr std::size_t kPixels = 2 * kHalf, kBytes = hn::MaxLanes(DU8());
  const std::size_t all = 3 * run.count;
  draw<kGather>(run, [=](VU pixels, std::size_t k) HWY_ATTR {
    const auto bytes = three_bytes<kSwap>(pixels);
    if (3 * k + kBytes <= all) {
      hn::StoreU(bytes, DU8(), out + 3 * k);  // the next ones overwrite what is too much
    } else {
      alignas(64) std::array<std::uint8_t, kBytes> last;
      hn::Store(bytes, DU8(), last.data());
      std::memcpy(out + 3 * k, last.data(), std::min(3 * kPixels, all - 3 * k));
    }
  });
}

template <bool kGather>
void draw_rgba(const TapRun& run, std::uint32_t* out) {
  const std::size_t count = run.count;
  draw<kGather>(run, [=](VU pixels, std::size_t k) HWY_ATTR {
    if (k + 2 * kHalf <= count) {
      hn::StoreU(in_order(pixels), DU(), out + k);
    } else {
      alignas(64) std::array<std::uint32_t, 2 * kHalf> last;
      hn::Store(in_order(pixels), DU(), last.data());
      std::memcpy(out + k, last.data(), 4 * (count - k));
    }
  });
}

// --- nearest ------------------------------------------------------------------------------------

// Bytes from a face's cells to the texels that hold points: nearest_offset().
template <class T>
struct NearestMaker {
  HWY_INLINE explicit NearestMaker(std::uint32_t size)
      : step(hn::Set(DI(), static_cast<std::int32_t>(image::ValueCells<T>::pitch(size)) -
                               static_cast<std::int32_t>(image::kCellBytes))),
        last(hn::Set(DI(), static_cast<std::int32_t>(size << 16) - 1)) {}

  HWY_INLINE VI make(VI x, VI y) const {
    constexpr int kShift = sizeof(T) == 2 ? 5 : 4;
    static_assert(image::ValueCells<T>::kColumns == 1U << kShift);
    const VI column = inside(x), row = inside(y);
    const VI strip = hn::Mul(hn::ShiftRight<16 + kShift>(column), step);
    const VI texel = add_products(strip, column, hn::Set(DI(), halves(sizeof(T), 0)));
    return add_products(texel, row, hn::Set(DI(), halves(64, 0)));
  }

 private:
  HWY_INLINE VI inside(VI v) const {
    return hn::Min(hn::Max(hn::Sub(v, hn::Set(DI(), 32768)), hn::Zero(DI())), last);
  }
  VI step, last;
};

// The values at offsets, in the lower bits of each lane; what is above is not theirs.
template <bool kGather, class T>
HWY_INLINE VI values_at(const std::uint8_t* cells, VI offset) {
#if EN_X86_512
  if constexpr (kGather) {
    return VI{_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), 0xFFFF, offset.raw, cells, 1)};
  }
#elif HWY_TARGET == HWY_AVX2
  if constexpr (kGather) {
    return VI{_mm256_mask_i32gather_epi32(_mm256_setzero_si256(),
                                          reinterpret_cast<const int*>(cells), offset.raw,
                                          _mm256_set1_epi32(-1), 1)};
  }
#endif
  alignas(64) std::array<std::int32_t, hn::MaxLanes(DI())> at, values;
  hn::Store(offset, DI(), at.data());
#pragma GCC unroll 16
  for (std::size_t k = 0; k < at.size(); ++k) {
    T value;
    std::memcpy(&value, cells + at[k], sizeof(T));
    values[k] = static_cast<std::int32_t>(value);
  }
  return hn::Load(DI(), values.data());
}

HWY_INLINE void store_values(VI values, std::uint32_t* out) {
  hn::StoreU(hn::BitCast(DU(), values), DU(), out);
}
HWY_INLINE void store_values(VI values, std::uint16_t* out) {
#if EN_X86_512
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), _mm512_cvtepi32_epi16(values.raw));
#else
  const hn::Rebind<std::uint16_t, DI> d16;
  hn::StoreU(hn::DemoteTo(d16, hn::And(values, hn::Set(DI(), 0xFFFF))), d16, out);
#endif
}

template <bool kGather, class T>
void nearest(const Points& points, std::size_t from, const Face& face, std::size_t count, T* out) {
  const NearestMaker<T> maker(face.size);
  for (std::size_t k = 0; k < count; k += hn::Lanes(DI())) {
    const VI offset = maker.make(hn::LoadU(DI(), points.x.data() + from + k),
                                 hn::LoadU(DI(), points.y.data() + from + k));
    store_values(values_at<kGather, T>(face.cells, offset), out + k);
  }
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

// Channels as numbers; constants stay in registers.
struct Planar {
  HWY_INLINE explicit Planar(const PlanarScale& scale)
      : factor0(hn::Set(DF(), scale.factor[0])),
        factor1(hn::Set(DF(), scale.factor[1])),
        factor2(hn::Set(DF(), scale.factor[2])),
        offset0(hn::Set(DF(), scale.offset[0])),
        offset1(hn::Set(DF(), scale.offset[1])),
        offset2(hn::Set(DF(), scale.offset[2])) {}

  template <int kChannel>
  HWY_INLINE VF of(VU rgba) const {
    return scaled<kChannel>(hn::And(hn::ShiftRight<8 * kChannel>(rgba), hn::Set(DU(), 0xFFU)));
  }

 private:
  template <int kChannel>
  HWY_INLINE VF scaled(VU value) const {
    const VF v = hn::ConvertTo(DF(), hn::BitCast(DI(), value));
    if constexpr (kChannel == 0) return hn::Add(hn::Mul(v, factor0), offset0);
    if constexpr (kChannel == 1) return hn::Add(hn::Mul(v, factor1), offset1);
    return hn::Add(hn::Mul(v, factor2), offset2);
  }

  VF factor0, factor1, factor2, offset0, offset1, offset2;
};

HWY_INLINE void store_planar(VF value, float* out) { hn::StoreU(value, DF(), out); }
#if EN_HALVES
HWY_INLINE void store_planar(VF value, std::uint16_t* out) {
  const hn::Rebind<hwy::float16_t, DF> d16;
  hn::StoreU(hn::DemoteTo(d16, value), d16, reinterpret_cast<hwy::float16_t*>(out));
}
#endif

// The whole registers among `count` pixels. Returns how many pixels they have.
template <class T>
HWY_INLINE std::size_t pack_planar_whole(const std::uint32_t* rgba, std::size_t count,
                                         const PlanarScale& scale, std::size_t plane, T* out) {
  const Planar planar(scale);
  const std::size_t n = hn::Lanes(DF()), whole = count - count % n;
  for (std::size_t k = 0; k < whole; k += n) {
    const VU pixels = hn::LoadU(DU(), rgba + k);
    store_planar(planar.of<0>(pixels), out + k);
    store_planar(planar.of<1>(pixels), out + plane + k);
    store_planar(planar.of<2>(pixels), out + 2 * plane + k);
  }
  return whole;
}

void pack_planar32(const std::uint32_t* rgba, std::size_t count, const PlanarScale& scale,
                   std::size_t plane, float* out) {
  const std::size_t whole = pack_planar_whole(rgba, count, scale, plane, out);
  scalar_kernels().pack_planar32(rgba + whole, count - whole, scale, plane, out + whole);
}

void pack_planar16(const std::uint32_t* rgba, std::size_t count, const PlanarScale& scale,
                   std::size_t plane, std::uint16_t* out) {
  std::size_t whole = 0;
#if EN_HALVES
  whole = pack_planar_whole(rgba, count, scale, plane, out);
#endif
  scalar_kernels().pack_planar16(rgba + whole, count - whole, scale, plane, out + whole);
}

// In two loops: one that draws and converts would run out of registers.
template <bool kGather>
void draw_planar16(const TapRun& run, const PlanarScale& scale, std::size_t plane,
                   std::uint16_t* out) {
  Block32 rgba;
  draw_rgba<kGather>(run, rgba.values.data());
  pack_planar16(rgba.values.data(), run.count, scale, plane, out);
}

template <bool kGather>
void draw_planar32(const TapRun& run, const PlanarScale& scale, std::size_t plane, float* out) {
  Block32 rgba;
  draw_rgba<kGather>(run, rgba.values.data());
  pack_planar32(rgba.values.data(), run.count, scale, plane, out);
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

template <bool kGather>
constexpr Kernels make_kernels() {
  return {
      "",
      points,
      taps,
      taps_and_points,
      draw_three<kGather, false>,
      draw_three<kGather, true>,
      draw_rgba<kGather>,
      draw_planar16<kGather>,
      draw_planar32<kGather>,
      nearest<kGather, std::uint16_t>,
      nearest<kGather, std::uint32_t>,
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
}

const Kernels* kernels(bool gathers) {
  static constexpr Kernels kLoads = make_kernels<false>();
#if EN_HALVES  // these targets have gathers, too
  static constexpr Kernels kGathers = make_kernels<true>();
  if (gathers) return &kGathers;
#else
  static_cast<void>(gathers);
#endif
  return &kLoads;
}

#endif
}  // namespace HWY_NAMESPACE
}  // namespace enfilade::render::cpu
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <chrono>

#include "enfilade/render/gl_devices.h"

namespace enfilade::render {
namespace cpu {
namespace {

HWY_EXPORT(kernels);

std::vector<KernelVariant> find_variants() {
  std::vector<KernelVariant> found;
  // Highway numbers the targets so that the better ones have the lower bits. The one compiled for
  // every machine of this kind counts even where an extension that Highway wants with it, and we do
  // not use, is missing (the Raspberry Pi 4 has no AES). Another thread that dispatches meanwhile
  // may get a lesser target, which works as well.
  std::int64_t supported = (hwy::SupportedTargets() | HWY_STATIC_TARGET) & HWY_TARGETS;
  for (; supported != 0; supported &= supported - 1) {
    const std::int64_t target = supported & -supported;
    hwy::GetChosenTarget().Update(target);
    const Kernels* loads = HWY_DYNAMIC_DISPATCH(kernels)(false);
    const Kernels* gathers = HWY_DYNAMIC_DISPATCH(kernels)(true);
    const std::string name = hwy::TargetName(target);
    if (gathers != loads) found.push_back({name + " gathers", gathers});
    found.push_back({name, loads});
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return found;
}

// Seconds that kernels take for a row of pixels, at best.
double time_row(const Kernels& kernels) {
  constexpr std::size_t kPixels = 512, kLines = 512;
  alignas(64) static std::array<std::uint8_t, kLines * image::kCellBytes + image::kCellBytes> cells;
  Taps taps;
  for (std::size_t k = 0; k < taps.offset.size(); ++k) {  // as a row that runs through many lines
    taps.offset[k] = static_cast<std::int32_t>(k * 5 % kLines * image::kCellBytes + k % 18 * 3);
    taps.weights[k] = static_cast<std::uint32_t>(k << 16 | 0x80 << 8 | 0x7F);
  }
  std::array<std::uint32_t, kPixels> out;
  double best = 1;
  for (int k = 0; k < 16; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    kernels.draw_rgba({cells.data(), taps, 0, kPixels}, out.data());
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
    best = std::min(best, spent.count());
  }
  return best;
}

const KernelVariant& choose() {
  const auto& variants = kernel_variants();
  // Of the best target: some processors gather quickly, others load one by one as fast.
  const bool choice = variants.size() > 1 && variants[0].name.starts_with(variants[1].name);
  if (choice && time_row(*variants[1].kernels) < time_row(*variants[0].kernels)) {
    return variants[1];
  }
  return variants[0];
}

const KernelVariant& chosen() {
  static const KernelVariant& variant = choose();
  return variant;
}

}  // namespace

const std::vector<KernelVariant>& kernel_variants() {
  static const std::vector<KernelVariant> variants = find_variants();
  return variants;
}

const Kernels& simd_kernels() noexcept { return *chosen().kernels; }

const Kernels& simd_kernels(const std::string& target) {
  if (target.empty()) return simd_kernels();
  const auto& variants = kernel_variants();
  const auto found = std::ranges::find(variants, target, &KernelVariant::name);
  if (found == variants.end()) {
    throw ArgumentError(fmt::format("config.cpu_target: {:?} is none of this machine's: {}", target,
                                    fmt::join(cpu_targets(), ", ")));
  }
  return *found->kernels;
}

}  // namespace cpu

std::string cpu_target() { return cpu::chosen().name; }

std::vector<std::string> cpu_targets() {
  std::vector<std::string> names;
  for (const auto& variant : cpu::kernel_variants()) names.push_back(variant.name);
  return names;
}

}  // namespace enfilade::render
#endif
