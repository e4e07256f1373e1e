/// \file  The inner loops of the CPU back end: one table of functions for each instruction set, and
/// the scalar reference. All give the same bytes.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "enfilade/render/cpu/row_plan.h"
#include "enfilade/render/face_cache.h"

namespace enfilade::render::cpu {

/// Kernels work on pieces of a row of at most this many pixels, in buffers on the stack.
inline constexpr std::size_t kBlock = 1024;
/// Number of values that kernels may write beyond the requested pixels.
inline constexpr std::size_t kSlack = 64;

/// Values of a piece of a row, before they are packed into the caller's format.
struct Block16 {
  alignas(64) std::array<std::uint16_t, kBlock + kSlack> values;
};
struct Block32 {
  alignas(64) std::array<std::uint32_t, kBlock + kSlack> values;
};

/// texel_point() of each pixel of a piece.
struct Points {
  alignas(64) std::array<std::int32_t, kBlock + kSlack> x, y;
};

/// Where each pixel's nearest texel is, in bytes from an address that the pieces of a row share.
struct Places {
  alignas(64) std::array<std::int32_t, kBlock + kSlack> offset;
};

/// tap_at() of each pixel of a piece; offsets are from an address that the pieces of a row share.
struct TexelTaps {
  alignas(64) std::array<std::int32_t, kBlock + kSlack> offset;
  alignas(64) std::array<std::uint32_t, kBlock + kSlack> weights;
};

/// Some taps, and the address that their offsets are from. Whole registers are read: the offsets
/// of kTapsBeyond more taps must lead to texels, too.
inline constexpr std::size_t kTapsBeyond = 15;
struct TapRun {
  const std::uint8_t* base;
  const TexelTaps& taps;
  std::size_t from, count;
};

/// Offsets, and the address that they count from; read like a TapRun's.
struct PlaceRun {
  const std::uint8_t* base;
  const Places& places;
  std::size_t from, count;
};

/// Columns begin .. end-1 of a row; at most kBlock of them.
struct PixelRange {
  std::uint32_t begin = 0, end = 0;
  std::uint32_t size() const noexcept { return end - begin; }
};

/// The colour face that a piece lies on.
struct ColourFace {
  const std::uint8_t* base;  ///< origin of the offsets
  std::int32_t first;        ///< bytes from there to its cells
  std::uint32_t size;
  bool clamped;  ///< filtered within the face only
};

/// The face of a layer of 16 or 32 bits that a piece lies on.
struct NearestFace {
  const std::uint8_t* base;  ///< origin of the offsets
  std::int32_t first;        ///< bytes from there to its cells
  std::uint32_t size;
};

/// A piece of a block's row whose taps are to be computed.
struct TapPart {
  FaceLine line;
  PixelRange piece;
  ColourFace face;
  std::size_t at;  ///< where the block has the piece
};

/// A block whose taps are computed while another one is drawn, where there are registers enough.
/// Their divisions keep a unit busy that drawing does not need. Prefetches the texels, too. Writes
/// whole registers: values beyond a part's end are arbitrary, and the next part overwrites them.
struct Ahead {
  std::span<const TapPart> parts;
  TexelTaps& taps;  ///< not those that are drawn
  Points* points;   ///< where the same pixels' points go; null: nowhere
};

/// Multiplies and adds so that an 8-bit value becomes (value / 255 - mean) / deviation.
struct PlanarScale {
  std::array<float, 3> factor, offset;
};

/// How many of a block's texels are prefetched: those of each 16th pixel, or of each 8th and of the
/// row below.
enum class Ask { kLittle, kMuch };

struct PixelKernels {
  /// Where the pixels of a piece meet the face that it lies on; written from the place `at` on.
  void (*points)(const FaceLine&, PixelRange, std::size_t at, Points& out);
  /// Where the colour of a block's pixels is.
  void (*taps)(const Ahead&);
  // Bilinear colour of the taps `from` .. from + count - 1, in each of the formats; never writes
  // beyond them. RGBA: A = 255. Does the work of `taps`, too.
  void (*draw_rgb)(const TapRun&, const Ahead&, std::uint8_t* out);
  void (*draw_bgr)(const TapRun&, const Ahead&, std::uint8_t* out);
  void (*draw_rgba)(const TapRun&, const Ahead&, std::uint32_t* out);
  void (*draw_planar16)(const TapRun&, const Ahead&, const PlanarScale&, std::size_t plane,
                        std::uint16_t* out);
  void (*draw_planar32)(const TapRun&, const Ahead&, const PlanarScale&, std::size_t plane,
                        float* out);
  /// For layers of 16 and 32 bits: finds the texels that hold the points `from` .. from + count -
  /// 1, and prefetches them. Writes the same entries of `out`, and whole registers, as `taps` does.
  void (*places16)(const Points&, std::size_t from, std::size_t count, const NearestFace&,
                   Places& out);
  void (*places32)(const Points&, std::size_t from, std::size_t count, const NearestFace&,
                   Places& out);
  /// Their values. Writes whole registers.
  void (*values16)(const PlaceRun&, std::uint16_t* out);
  void (*values32)(const PlaceRun&, std::uint32_t* out);
  // values16, and pack_metres or pack_units; never writes beyond the places.
  void (*draw_metres)(const PlaceRun&, const float* factor, float* out);
  void (*draw_units)(const PlaceRun&, const float* factor, std::uint16_t* out);

  // From a block to the caller's memory, `count` pixels; never writes beyond them.
  void (*pack_rgb)(const std::uint32_t* rgba, std::size_t count, std::uint8_t* out);
  void (*pack_bgr)(const std::uint32_t* rgba, std::size_t count, std::uint8_t* out);
  /// `plane` values lie between a pixel's R, G and B.
  void (*pack_planar16)(const std::uint32_t* rgba, std::size_t count, const PlanarScale&,
                        std::size_t plane, std::uint16_t* out);
  void (*pack_planar32)(const std::uint32_t* rgba, std::size_t count, const PlanarScale&,
                        std::size_t plane, float* out);
  /// A copy that leaves the caches to the texels; visible to other threads after stream_end().
  void (*stream)(std::byte* out, const std::byte* from, std::size_t bytes);
  void (*stream_end)();
  // Depth: `factor[k]` turns a ray's length into the requested measure.
  void (*pack_metres)(const std::uint16_t* units, const float* factor, std::size_t count,
                      float* out);
  void (*pack_units)(const std::uint16_t* units, const float* factor, std::size_t count,
                     std::uint16_t* out);
  /// round(z / 257) * 257: an 8-bit colour buffer's steps
  void (*pack_legacy_units)(const std::uint16_t* units, const float* factor, std::size_t count,
                            std::uint16_t* out);
  void (*pack_legacy_metres)(const std::uint16_t* units, const float* factor, std::size_t count,
                             float* out);
};

const PixelKernels& scalar_kernels() noexcept;
/// The fastest kernels here: for the best instruction set of the processor, with or without
/// gathers. A short measurement at the first call decides. All give the same bytes.
const PixelKernels& simd_kernels() noexcept;
/// The kernels of one of cpu_targets(); empty: the fastest. \throws ArgumentError for another name
const PixelKernels& simd_kernels(const std::string& target);

struct KernelVariant {
  std::string name;  ///< "AVX2", "AVX2 gathers", ...
  const PixelKernels* kernels;
};
/// All that the processor supports, the best instruction set first.
const std::vector<KernelVariant>& kernel_variants();

}  // namespace enfilade::render::cpu
