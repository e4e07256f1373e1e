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
#include "enfilade/render/cpu/row_plan.h"

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
const PixelKernels* kernels(bool /*gathers*/, Ask /*ask*/) { return &scalar_kernels(); }

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
// Highway 1.0 does not name VNNI to clang. The sum is the same.
#if EN_X86_DL && !defined(__clang__)
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
HWY_INLINE VI upper_products(VI a, VI b) {
  return hn::BitCast(DI(), hn::MulHigh(hn::BitCast(DU16(), a), hn::BitCast(DU16(), b)));
}

HWY_INLINE VI scale15(VI a, VI b) {
  return hn::BitCast(DI(), hn::MulFixedPoint15(hn::BitCast(DI16(), a), hn::BitCast(DI16(), b)));
}

// Keeps a constant in a register or in memory: the compiler would make it anew in each round of a
// loop that has many, and that takes the port of the shuffles.
template <class V>
HWY_INLINE V held(V constant) {
#if HWY_ARCH_X86 && HWY_COMPILER_GCC
  asm("" : "+v"(constant.raw));
#endif
  return constant;
}
// All lanes of a gather. The compiler must not know that they are all: it would leave out the
// zeroes that a gather starts from, and each would wait for what its register held before.
#if EN_X86_512
template <class Mask>
HWY_INLINE Mask all_lanes() {
  auto all = static_cast<Mask>(-1);
  asm("" : "+Yk"(all));
  return all;
}
#elif HWY_TARGET == HWY_AVX2
HWY_INLINE __m256i all_lanes() { return held(hn::Set(DI(), -1)).raw; }
#endif
HWY_INLINE VI held_halves(std::int32_t high, std::int32_t low) {
  return held(hn::Set(DI(), halves(high, low)));
}

// Each uses what the ones before define.
// clang-format off
#include "enfilade/render/cpu/simd_points.inc"
#include "enfilade/render/cpu/simd_colour.inc"
#include "enfilade/render/cpu/simd_pack.inc"
// clang-format on

template <bool kGather, Ask kAsk>
constexpr PixelKernels make_kernels() {
  return {
      .points = points,
      .taps = taps<kAsk>,
      .draw_rgb = draw_three<kAsk, kGather, false>,
      .draw_bgr = draw_three<kAsk, kGather, true>,
      .draw_rgba = draw_rgba<kAsk, kGather>,
      .draw_planar16 = draw_planar16<kAsk, kGather>,
      .draw_planar32 = draw_planar32<kAsk, kGather>,
      .places16 = places<kAsk, std::uint16_t>,
      .places32 = places<kAsk, std::uint32_t>,
      .values16 = values<kGather, std::uint16_t>,
      .values32 = values<kGather, std::uint32_t>,
      .draw_metres = draw_metres<kGather>,
      .draw_units = draw_units<kGather>,
      .pack_rgb = pack_three<false>,
      .pack_bgr = pack_three<true>,
      .pack_planar16 = pack_planar16,
      .pack_planar32 = pack_planar32,
      .stream = stream,
      .stream_end = stream_end,
      .pack_metres = pack_metres,
      .pack_units = pack_units,
      .pack_legacy_units = pack_legacy_units,
      .pack_legacy_metres = pack_legacy_metres,
  };
}

template <Ask kAsk>
const PixelKernels* kernels_that(bool gathers) {
  static constexpr PixelKernels kLoads = make_kernels<false, kAsk>();
#if EN_HALVES  // these targets have gathers, too
  static constexpr PixelKernels kGathers = make_kernels<true, kAsk>();
  if (gathers) return &kGathers;
#else
  static_cast<void>(gathers);
#endif
  return &kLoads;
}

const PixelKernels* kernels(bool gathers, Ask ask) {
  return ask == Ask::kMuch ? kernels_that<Ask::kMuch>(gathers)
                           : kernels_that<Ask::kLittle>(gathers);
}

#endif
}  // namespace HWY_NAMESPACE
}  // namespace enfilade::render::cpu
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <chrono>

#include "enfilade/render/devices.h"

namespace enfilade::render {
namespace cpu {
namespace {

HWY_EXPORT(kernels);

// Intel's processors follow strips of texels by themselves, and asking for more than the first line
// keeps them waiting; AMD's do not: docs/design/kernels.md has the figures. Others: not measured.
Ask best_ask() {
#if HWY_ARCH_X86
  return __builtin_cpu_is("intel") ? Ask::kLittle : Ask::kMuch;
#else
  return Ask::kMuch;
#endif
}

std::vector<KernelVariant> find_variants() {
  const Ask ask = best_ask();
  std::vector<KernelVariant> found;
  // Highway numbers the targets so that the better ones have the lower bits. The one compiled for
  // every machine of this kind counts even where an extension that Highway wants with it, and we do
  // not use, is missing (the Raspberry Pi 4 has no AES). Another thread that dispatches meanwhile
  // may get a lesser target, which works as well.
  std::int64_t supported = (hwy::SupportedTargets() | HWY_STATIC_TARGET) & HWY_TARGETS;
  for (; supported != 0; supported &= supported - 1) {
    const std::int64_t target = supported & -supported;
    hwy::GetChosenTarget().Update(target);
    const PixelKernels* loads = HWY_DYNAMIC_DISPATCH(kernels)(false, ask);
    const PixelKernels* gathers = HWY_DYNAMIC_DISPATCH(kernels)(true, ask);
    const std::string name = hwy::TargetName(target);
    if (gathers != loads) found.push_back({name + " gathers", gathers});
    found.push_back({name, loads});
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return found;
}

// Seconds that kernels take for a row of pixels, at best.
double time_row(const PixelKernels& kernels) {
  constexpr std::size_t kPixels = 512, kLines = 512;
  alignas(64) static std::array<std::uint8_t, kLines * image::kCellBytes + image::kCellBytes> cells;
  TexelTaps taps, no_taps;
  for (std::size_t k = 0; k < taps.offset.size(); ++k) {  // as a row that runs through many lines
    taps.offset[k] = static_cast<std::int32_t>(k * 5 % kLines * image::kCellBytes + k % 18 * 3);
    taps.weights[k] = static_cast<std::uint32_t>(k << 16 | 0x80 << 8 | 0x7F);
  }
  std::array<std::uint32_t, kPixels> out;
  double best = 1;
  for (int k = 0; k < 16; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    kernels.draw_rgba({cells.data(), taps, 0, kPixels}, {{}, no_taps, nullptr}, out.data());
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
    best = std::min(best, spent.count());
  }
  return best;
}

const KernelVariant& choose() {
  const auto& variants = kernel_variants();
  // Variants of the best target: some processors gather quickly, others load one by one as fast.
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
  static const std::vector<KernelVariant> kVariants = find_variants();
  return kVariants;
}

const PixelKernels& simd_kernels() noexcept { return *chosen().kernels; }

const PixelKernels& simd_kernels(const std::string& target) {
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
