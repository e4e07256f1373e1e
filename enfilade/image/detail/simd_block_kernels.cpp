// block_kernels.h once for each instruction set that Highway knows; the best is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "enfilade/image/detail/simd_block_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include "enfilade/image/detail/block_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace enfilade::image::detail {
namespace HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128

const BlockKernels* kernels() { return &scalar_block_kernels(); }

#else
namespace hn = hwy::HWY_NAMESPACE;

// Two blocks, or 16 pixels, where registers are that long. What goes across lanes (interleaving,
// packing) stays within 128 bits.
using D16 = hn::CappedTag<std::int16_t, 16>;
using D8 = hn::Rebind<std::uint8_t, D16>;  // as many lanes, of half the bytes
using D32 = hn::Repartition<std::int32_t, D16>;
using D64 = hn::Repartition<std::int64_t, D16>;
using DU16 = hn::RebindToUnsigned<D16>;
using DU8 = hn::Repartition<std::uint8_t, D16>;
using V16 = hn::Vec<D16>;
using V32 = hn::Vec<D32>;

// Sums of the products of neighbouring lanes. (Highway 1.0 has no name for it.)
HWY_INLINE V32 pair_products(V16 a, V16 b) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
  return V32{_mm256_madd_epi16(a.raw, b.raw)};
#elif HWY_ARCH_X86
  return V32{_mm_madd_epi16(a.raw, b.raw)};
#else
  const D32 d;
  const V32 x = hn::BitCast(d, a), y = hn::BitCast(d, b);
  const V32 low =
      hn::Mul(hn::ShiftRight<16>(hn::ShiftLeft<16>(x)), hn::ShiftRight<16>(hn::ShiftLeft<16>(y)));
  return hn::Add(low, hn::Mul(hn::ShiftRight<16>(x), hn::ShiftRight<16>(y)));
#endif
}

// Lane by lane a * first + b * second, for the eight lanes of a and b.
struct Wide {
  V32 low, high;
};
HWY_INLINE Wide add(Wide a, Wide b) { return {hn::Add(a.low, b.low), hn::Add(a.high, b.high)}; }
HWY_INLINE Wide subtract(Wide a, Wide b) {
  return {hn::Sub(a.low, b.low), hn::Sub(a.high, b.high)};
}

struct Pairs {
  HWY_INLINE Pairs(V16 a, V16 b)
      : low(hn::InterleaveLower(D16(), a, b)), high(hn::InterleaveUpper(D16(), a, b)) {}
  HWY_INLINE Wide times(int first, int second) const {
    const auto both = static_cast<std::int32_t>(static_cast<std::uint32_t>(second) << 16U |
                                                (static_cast<std::uint32_t>(first) & 0xFFFFU));
    const V16 factors = hn::BitCast(D16(), hn::Set(D32(), both));
    return {pair_products(low, factors), pair_products(high, factors)};
  }
  V16 low, high;
};

HWY_INLINE Wide scaled(V16 v) {
  constexpr int kDrop = 16 - TransformConstants::kBits;
  const V16 zero = hn::Zero(D16());
  return {hn::ShiftRight<kDrop>(hn::BitCast(D32(), hn::InterleaveLower(D16(), zero, v))),
          hn::ShiftRight<kDrop>(hn::BitCast(D32(), hn::InterleaveUpper(D16(), zero, v)))};
}

template <int kDrop>
HWY_INLINE V16 rounded(Wide v) {
  const V32 half = hn::Set(D32(), 1 << (kDrop - 1));
  return hn::ReorderDemote2To(D16(), hn::ShiftRight<kDrop>(hn::Add(v.low, half)),
                              hn::ShiftRight<kDrop>(hn::Add(v.high, half)));
}

// transform8() of the scalar kernels for eight columns at once.
template <int kDrop>
HWY_INLINE void pass(V16& v0, V16& v1, V16& v2, V16& v3, V16& v4, V16& v5, V16& v6, V16& v7) {
  using C = TransformConstants;
  const Pairs p26(v2, v6);
  const Wide even2 = p26.times(C::k0541, C::k0541 - C::k1847);
  const Wide even3 = p26.times(C::k0541 + C::k0765, C::k0541);
  const Wide even0 = scaled(hn::Add(v0, v4)), even1 = scaled(hn::Sub(v0, v4));
  const Wide t0 = add(even0, even3), t3 = subtract(even0, even3);
  const Wide t1 = add(even1, even2), t2 = subtract(even1, even2);
  const Pairs z34(hn::Add(v7, v3), hn::Add(v5, v1));
  const Wide s3 = z34.times(C::k1175 - C::k1961, C::k1175);
  const Wide s4 = z34.times(C::k1175, C::k1175 - C::k0390);
  const Pairs p71(v7, v1), p53(v5, v3);
  const Wide o0 = add(p71.times(-C::k0899, C::k1501 - C::k0899), s4);
  const Wide o1 = add(p53.times(-C::k2562, C::k3072 - C::k2562), s3);
  const Wide o2 = add(p53.times(C::k2053 - C::k2562, -C::k2562), s4);
  const Wide o3 = add(p71.times(C::k0298 - C::k0899, -C::k0899), s3);
  v0 = rounded<kDrop>(add(t0, o0));
  v7 = rounded<kDrop>(subtract(t0, o0));
  v1 = rounded<kDrop>(add(t1, o1));
  v6 = rounded<kDrop>(subtract(t1, o1));
  v2 = rounded<kDrop>(add(t2, o2));
  v5 = rounded<kDrop>(subtract(t2, o2));
  v3 = rounded<kDrop>(add(t3, o3));
  v4 = rounded<kDrop>(subtract(t3, o3));
}

HWY_INLINE void interleave(V16& a, V16& b) {
  const V16 low = hn::InterleaveLower(D16(), a, b);
  b = hn::InterleaveUpper(D16(), a, b);
  a = low;
}
template <class D>
HWY_INLINE void interleave_as(D d, V16& a, V16& b) {
  const auto x = hn::BitCast(d, a), y = hn::BitCast(d, b);
  a = hn::BitCast(D16(), hn::InterleaveLower(d, x, y));
  b = hn::BitCast(D16(), hn::InterleaveUpper(d, x, y));
}

HWY_INLINE void transpose(V16& v0, V16& v1, V16& v2, V16& v3, V16& v4, V16& v5, V16& v6, V16& v7) {
  interleave(v0, v1);
  interleave(v2, v3);
  interleave(v4, v5);
  interleave(v6, v7);
  // v0: rows 0 and 1, columns 0 to 3; v1: columns 4 to 7; and so on.
  const D32 d32;
  interleave_as(d32, v0, v2);
  interleave_as(d32, v1, v3);
  interleave_as(d32, v4, v6);
  interleave_as(d32, v5, v7);
  // v0: rows 0 to 3, columns 0 and 1; v2: columns 2 and 3; v1: 4 and 5; v3: 6 and 7.
  const D64 d64;
  interleave_as(d64, v0, v4);
  interleave_as(d64, v2, v6);
  interleave_as(d64, v1, v5);
  interleave_as(d64, v3, v7);
  // Columns 0 to 7: v0 v4 v2 v6 v1 v5 v3 v7.
  const V16 c1 = v4, c2 = v2, c3 = v6, c4 = v1, c5 = v5, c6 = v3;
  v1 = c1;
  v2 = c2;
  v3 = c3;
  v4 = c4;
  v5 = c5;
  v6 = c6;
}

// A row of a block, in 8 lanes; of two blocks, in 16.
HWY_INLINE V16 load_row(const std::int16_t* first, const std::int16_t* second) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
  const hn::Half<D16> half;
  return hn::Combine(D16(), hn::LoadU(half, second), hn::LoadU(half, first));
#else
  static_cast<void>(second);
  return hn::LoadU(D16(), first);
#endif
}

HWY_INLINE void store_row(V16 row, std::uint8_t* first, std::uint8_t* second) {
  const hn::Rebind<std::int8_t, D16> signs;
  const D8 d;
  const auto bytes =
      hn::Xor(hn::BitCast(d, hn::DemoteTo(signs, row)), hn::Set(d, std::uint8_t{0x80}));
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
  const hn::Half<D8> half;
  hn::StoreU(hn::LowerHalf(half, bytes), half, first);
  hn::StoreU(hn::UpperHalf(half, bytes), half, second);
#else
  static_cast<void>(second);
  hn::StoreU(bytes, d, first);
#endif
}

HWY_INLINE void transform_lanes(const std::int16_t* one, const std::int16_t* two,
                                std::uint8_t* first, std::uint8_t* second, std::size_t pitch) {
  using C = TransformConstants;
  V16 v0 = load_row(one, two), v1 = load_row(one + 8, two + 8), v2 = load_row(one + 16, two + 16),
      v3 = load_row(one + 24, two + 24), v4 = load_row(one + 32, two + 32),
      v5 = load_row(one + 40, two + 40), v6 = load_row(one + 48, two + 48),
      v7 = load_row(one + 56, two + 56);
  pass<C::kFirst>(v0, v1, v2, v3, v4, v5, v6, v7);
  transpose(v0, v1, v2, v3, v4, v5, v6, v7);
  pass<C::kSecond>(v0, v1, v2, v3, v4, v5, v6, v7);
  transpose(v0, v1, v2, v3, v4, v5, v6, v7);
  store_row(v0, first, second);
  store_row(v1, first + pitch, second + pitch);
  store_row(v2, first + 2 * pitch, second + 2 * pitch);
  store_row(v3, first + 3 * pitch, second + 3 * pitch);
  store_row(v4, first + 4 * pitch, second + 4 * pitch);
  store_row(v5, first + 5 * pitch, second + 5 * pitch);
  store_row(v6, first + 6 * pitch, second + 6 * pitch);
  store_row(v7, first + 7 * pitch, second + 7 * pitch);
}

void transform(const std::int16_t* blocks, std::uint8_t* first, std::uint8_t* second,
               std::size_t pitch) {
  const std::int16_t* const other = blocks + 64;
  transform_lanes(blocks, other, first, second, pitch);
  if (hn::Lanes(D16()) == 8) transform_lanes(other, other, second, second, pitch);
}

HWY_INLINE V16 promoted(const std::uint8_t* from) {
  return hn::PromoteTo(D16(), hn::LoadU(D8(), from));
}

void upsample(ChromaRows rows, std::size_t width, std::uint16_t* sums, std::uint8_t* out) {
  const DU16 d;
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t x = 0; x < width; x += lanes) {
    const V16 near = promoted(rows.near + x);
    const V16 sum = hn::Add(hn::Add(near, hn::Add(near, near)), promoted(rows.far + x));
    hn::StoreU(hn::BitCast(d, sum), d, sums + x + 1);
  }
  sums[0] = sums[1];
  sums[width + 1] = sums[width];
  for (std::size_t x = 0; x < width; x += lanes) {
    const auto middle = hn::LoadU(d, sums + x + 1);
    const auto three = hn::Add(middle, hn::Add(middle, middle));
    const auto even = hn::ShiftRight<4>(
        hn::Add(hn::Add(three, hn::LoadU(d, sums + x)), hn::Set(d, std::uint16_t{8})));
    const auto odd = hn::ShiftRight<4>(
        hn::Add(hn::Add(three, hn::LoadU(d, sums + x + 2)), hn::Set(d, std::uint16_t{7})));
    // The even one in the lower byte: lanes are little-endian wherever Highway has vectors.
    hn::StoreU(hn::BitCast(DU8(), hn::Or(even, hn::ShiftLeft<8>(odd))), DU8(), out + 2 * x);
  }
}

void to_rgb(const std::uint8_t* y, const std::uint8_t* cb, const std::uint8_t* cr,
            std::size_t width, std::uint8_t* rgb) {
  using C = ColourConstants;
  const D16 d;
  const D8 d8;
  const V16 middle = hn::Set(d, 128), one = hn::Set(d, 1);
  const V32 half = hn::Set(D32(), 1 << 15);
  // Half of floor(2 x factor / 65536) + 1 is x factor / 65536, rounded.
  const auto product = [=](V16 v, int factor) HWY_ATTR {
    const V16 twice = hn::MulHigh(hn::Add(v, v), hn::Set(d, static_cast<std::int16_t>(factor)));
    return hn::ShiftRight<1>(hn::Add(twice, one));
  };
  for (std::size_t x = 0; x < width; x += hn::Lanes(d)) {
    const V16 luma = promoted(y + x);
    const V16 b = hn::Sub(promoted(cb + x), middle), r = hn::Sub(promoted(cr + x), middle);
    // Factors above 1/2 are split, so that each fits into 16 bits with its sign.
    const V16 red = hn::Add(hn::Add(luma, r), product(r, C::k1402 - 65536));
    const V16 blue = hn::Add(hn::Add(luma, hn::Add(b, b)), product(b, C::k1772 - 131072));
    const Wide sum = Pairs(b, r).times(-C::k0344, 65536 - C::k0714);
    const V16 parts = hn::ReorderDemote2To(d, hn::ShiftRight<16>(hn::Add(sum.low, half)),
                                           hn::ShiftRight<16>(hn::Add(sum.high, half)));
    const V16 green = hn::Add(luma, hn::Sub(parts, r));
    hn::StoreInterleaved3(hn::DemoteTo(d8, red), hn::DemoteTo(d8, green), hn::DemoteTo(d8, blue),
                          d8, rgb + 3 * x);
  }
}

const BlockKernels* kernels() {
  static constexpr BlockKernels kKernels{transform, upsample, to_rgb};
  return &kKernels;
}

#endif
}  // namespace HWY_NAMESPACE
}  // namespace enfilade::image::detail
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace enfilade::image::detail {

HWY_EXPORT(kernels);

const BlockKernels& block_kernels() noexcept {
  static const BlockKernels& chosen = *HWY_DYNAMIC_DISPATCH(kernels)();
  return chosen;
}

}  // namespace enfilade::image::detail
#endif
