/// \file  The kernels of the CUDA back end. NVRTC compiles this text, behind detail/pixels.h, for
/// the card; as plain C++ it is its own twin, in which lanes, warps and blocks are loops
/// (kernels_test.cpp). It includes nothing on the card.
#pragma once
#if !defined(__CUDACC_RTC__)
#include <array>
#include <bit>
#include <cstring>

#include "enfilade/core/half.h"
#include "enfilade/render/detail/pixels.h"
#endif

namespace enfilade::render::cuda {

using namespace pixels;  // NOLINT(google-build-using-namespace): one text, in two files

inline constexpr u32 kLanes = 32;     ///< of a warp
inline constexpr u32 kWarps = 8;      ///< of a block
inline constexpr u32 kBandRows = 32;  ///< rows of a view that a block draws
inline constexpr u32 kLayers = 4;     ///< by index(Layer)

/// A view, and the panorama that it shows, in the card's memory.
struct DeviceView {
  Rays rays;           ///< in the panorama frame
  u64 faces[kLayers];  ///< address of a layer's six faces, one after the other
  u32 sizes[kLayers];  ///< of its faces, in texels
};

/// Some views of one camera, and where their pictures go.
struct Job {
  const DeviceView* views;
  u32 width, height;
  u32 bands;       ///< of a view: ceil(height / kBandRows)
  u32 size_layer;  ///< the layer whose size of faces all that are drawn here have
  u8* colour;
  u8* depth;
  u8* classes;
  u32* instances;
  const float* depth_factors;  ///< one a pixel of a view; null: 1
  float factor[3], offset[3];  ///< of planar colour
};

enum ColourKind : u32 { kNoColour, kRgb, kBgr, kRgba, kPlanar16, kPlanar32 };
enum DepthKind : u32 { kNoDepth, kMetres, kUnits, kLegacyMetres, kLegacyUnits };
enum ClassKind : u32 { kNoClasses, kClass8, kClass16 };

/// What a kernel draws. Clamped: colour is filtered within faces only.
template <u32 Colour, u32 Depth, u32 Classes, bool Instances, bool Clamped = false>
struct Variant {
  static constexpr u32 kColour = Colour, kDepth = Depth, kClasses = Classes;
  static constexpr bool kClamped = Clamped;
  static constexpr bool kInstances = Instances;
  static constexpr bool kNearest = Depth != kNoDepth || Classes != kNoClasses || Instances;
};

// --- Colour on the card: strips of 8 texels of 4 bytes, R G B less 128 and nothing, border
// included; a strip's rows follow each other, so that a line of 128 bytes holds 8 x 4 texels, the
// texel below is 32 bytes on, and a view turned by any angle reads few lines.

#if !defined(EN_STRIP_BITS)
#define EN_STRIP_BITS 3
#endif
inline constexpr u32 kStripBits = EN_STRIP_BITS;
inline constexpr u32 kRowBytes = 4U << kStripBits;

EN_PIXELS u32 colour_pitch(u32 size) { return kRowBytes * (size + 2); }
/// Bytes of a colour face.
EN_PIXELS u32 colour_bytes(u32 size) {
  return ((size + 2 + (1U << kStripBits) - 1) >> kStripBits) * colour_pitch(size);
}
/// Bytes to a column, from the row's first; `step` is colour_pitch() - kRowBytes.
EN_PIXELS u32 column_offset(u32 x, u32 step) { return (x >> kStripBits) * step + 4 * x; }

// --- The other layers keep the cells of image/face_cells.h.

template <class T>
EN_PIXELS u32 value_bytes(u32 size) {
  constexpr u32 kColumns = 64 / sizeof(T);
  return (size + kColumns - 1) / kColumns * size * 64;
}
template <class T>
EN_PIXELS T value_at(u64 face, u32 size, u32 x, u32 y) {
  constexpr u32 kColumns = 64 / sizeof(T);
  const u32 offset = (x / kColumns * size + y) * 64 + x % kColumns * static_cast<u32>(sizeof(T));
  return *reinterpret_cast<const T*>(face + offset);
}

// --- Lanes. On the card a thread is one lane; in the twin a loop runs all 32 through each step.

#if defined(__CUDACC_RTC__)
template <class T>
struct PerLane {
  T value;
  __device__ __forceinline__ T& operator[](u32) { return value; }
};
template <class Each>
EN_PIXELS void each_lane(const Each& each) {
  each(threadIdx.x % kLanes);
}
template <class T>
EN_PIXELS T from_lane(PerLane<T>& values, u32 lane) {
  return __shfl_sync(0xFFFFFFFFU, values.value, lane);
}
EN_PIXELS u32 pick_bytes(u32 a, u32 b, u32 selector) { return __byte_perm(a, b, selector); }
// sum + four bytes with a sign times four without
EN_PIXELS i32 add_products(u32 texels, u32 weights) {
  i32 sum;
  asm("dp4a.s32.u32 %0, %1, %2, %3;" : "=r"(sum) : "r"(texels), "r"(weights), "r"(0));
  return sum;
}
EN_PIXELS u16 half_of(float value) {
  u16 bits;
  asm("cvt.rn.f16.f32 %0, %1;" : "=h"(bits) : "f"(value));
  return bits;
}
EN_PIXELS u32 texel_of(u64 address) { return __ldg(reinterpret_cast<const u32*>(address)); }
#else
template <class T>
using PerLane = std::array<T, kLanes>;
template <class Each>
void each_lane(const Each& each) {
  for (u32 lane = 0; lane < kLanes; ++lane) each(lane);
}
template <class T>
T from_lane(PerLane<T>& values, u32 lane) {
  return values[lane % kLanes];
}
inline u32 pick_bytes(u32 a, u32 b, u32 selector) {
  const u64 both = static_cast<u64>(b) << 32 | a;
  u32 picked = 0;
  for (u32 k = 0; k < 4; ++k) {
    picked |= static_cast<u32>(both >> 8 * (selector >> 4 * k & 7) & 255) << 8 * k;
  }
  return picked;
}
inline i32 add_products(u32 texels, u32 weights) {
  i32 sum = 0;
  for (u32 k = 0; k < 4; ++k) {
    sum += static_cast<signed char>(texels >> 8 * k) * static_cast<i32>(weights >> 8 * k & 255);
  }
  return sum;
}
inline u16 half_of(float value) { return to_half(value); }
inline u32 texel_of(u64 address) { return *reinterpret_cast<const u32*>(address); }
#endif

// --- Colour

/// R, G, B in the lowest three bytes; bilinear, to the bit as cpu::sample_colour().
/// \param face address of the face's first texel  \param step as of column_offset()
EN_PIXELS u32 sample_colour(u64 face, u32 step, TexelPoint p) {
  const u32 x = static_cast<u32>(p.x >> 16), y = static_cast<u32>(p.y >> 16);
  const u64 left = face + (column_offset(x, step) + y * kRowBytes);
  const u64 right = face + (column_offset(x + 1, step) + y * kRowBytes);
  const u32 top_left = texel_of(left), top_right = texel_of(right);
  const u32 bottom_left = texel_of(left + kRowBytes), bottom_right = texel_of(right + kRowBytes);
  // Bytes: the weights of left and right; and the same for a word's upper half.
  const u32 across = 255 + 255 * right_weight(p), across_high = across << 16;
  const i32 lower = static_cast<i32>(lower_weight(p)), upper = kWholeWeight - lower;
  // R left, R right, G left, G right; B left, B right.
  const u32 top_rg = pick_bytes(top_left, top_right, 0x5140);
  const u32 bottom_rg = pick_bytes(bottom_left, bottom_right, 0x5140);
  const u32 top_b = pick_bytes(top_left, top_right, 0x0062);
  const u32 bottom_b = pick_bytes(bottom_left, bottom_right, 0x0062);
  // scale15(scale15(top, upper) + scale15(bottom, lower), 256) + 128, with the sums of all
  // roundings, and the 128, added at once: both are whole multiples of what is cut off later.
  const auto channel = [&](u32 top, u32 bottom, u32 weights) {
    const i32 from_top =
        add_products(top, weights) * upper + ((1 << 14) + ((64 + (128 << 7)) << 15));
    const i32 from_bottom = add_products(bottom, weights) * lower + (1 << 14);
    return static_cast<u32>((from_top >> 15) + (from_bottom >> 15)) >> 7;
  };
  // What the upper halves of top_b and bottom_b hold has no weight.
  return channel(top_rg, bottom_rg, across) | channel(top_rg, bottom_rg, across_high) << 8 |
         channel(top_b, bottom_b, across) << 16;
}

/// Bytes of a pixel, of one plane where there are three.
EN_PIXELS constexpr u32 colour_bytes_of(u32 kind) {
  return kind == kPlanar16 ? 2 : kind == kRgba || kind == kPlanar32 ? 4 : 3;
}

/// Pixels of a row, of up to 32 lanes, from the first one's address on.
/// \param words whether `out` and `count` are multiples of 4
template <bool Swapped>
EN_PIXELS void store_bytes(PerLane<u32>& rgb, u8* out, u32 count, bool words) {
  if (Swapped) {
    each_lane([&](u32 lane) { rgb[lane] = pick_bytes(rgb[lane], 0, 0x4012); });
  }
  if (words) {
    // Of the 24 words that 32 pixels fill, lane k writes the k-th.
    each_lane([&](u32 lane) {
      const u32 pixel = lane * 4 / 3, into = lane % 3;
      const u32 a = from_lane(rgb, pixel), b = from_lane(rgb, pixel + 1);
      const u32 selector = into == 0 ? 0x4210 : into == 1 ? 0x5421 : 0x6542;
      if (lane < count / 4 * 3) reinterpret_cast<u32*>(out)[lane] = pick_bytes(a, b, selector);
    });
  } else {
    each_lane([&](u32 lane) {
      if (lane >= count) return;
      for (u32 c = 0; c < 3; ++c) out[3 * lane + c] = static_cast<u8>(rgb[lane] >> 8 * c);
    });
  }
}

template <class V>
EN_PIXELS void store_colour(const Job& job, PerLane<u32>& rgb, u8* out, u32 count, bool words) {
  if constexpr (V::kColour == kRgb || V::kColour == kBgr) {
    store_bytes<V::kColour == kBgr>(rgb, out, count, words);
  } else {
    const u64 plane = static_cast<u64>(job.width) * job.height;
    each_lane([&](u32 lane) {
      if (lane >= count) return;
      if constexpr (V::kColour == kRgba) {
        reinterpret_cast<u32*>(out)[lane] = rgb[lane] | 0xFF000000U;
      } else {
        for (u32 c = 0; c < 3; ++c) {
          const float value =
              static_cast<float>(rgb[lane] >> 8 * c & 255) * job.factor[c] + job.offset[c];
          if constexpr (V::kColour == kPlanar16) {
            reinterpret_cast<u16*>(out)[c * plane + lane] = half_of(value);
          } else {
            reinterpret_cast<float*>(out)[c * plane + lane] = value;
          }
        }
      }
    });
  }
}

// --- Depth, classes and instances of one pixel

template <class V>
EN_PIXELS void store_depth(const Job& job, u16 units, u64 pixel, u32 place) {
  const float value = scaled(units, job.depth_factors == nullptr ? 1.0F : job.depth_factors[place]);
  if constexpr (V::kDepth == kMetres) {
    reinterpret_cast<float*>(job.depth)[pixel] = value * kMetresPerUnit;
  } else if constexpr (V::kDepth == kUnits) {
    reinterpret_cast<u16*>(job.depth)[pixel] = rounded(value);
  } else if constexpr (V::kDepth == kLegacyMetres) {
    reinterpret_cast<float*>(job.depth)[pixel] =
        static_cast<float>(step257(value)) * kMetresPerUnit;
  } else {
    reinterpret_cast<u16*>(job.depth)[pixel] = static_cast<u16>(step257(value));
  }
}

template <class V>
EN_PIXELS void draw_nearest(const Job& job, const DeviceView& view, u32 face, TexelPoint p,
                            u64 pixel, u32 place) {
  const u32 size = view.sizes[job.size_layer];
  const u32 x = nearest_texel(p.x, size), y = nearest_texel(p.y, size);
  if constexpr (V::kDepth != kNoDepth) {
    const u64 first = view.faces[1] + static_cast<u64>(face) * value_bytes<u16>(size);
    store_depth<V>(job, value_at<u16>(first, size, x, y), pixel, place);
  }
  if constexpr (V::kClasses != kNoClasses) {
    const u64 first = view.faces[2] + static_cast<u64>(face) * value_bytes<u16>(size);
    const u16 value = value_at<u16>(first, size, x, y);
    if constexpr (V::kClasses == kClass8) {
      job.classes[pixel] = static_cast<u8>(value > 255 ? 255 : value);
    } else {
      reinterpret_cast<u16*>(job.classes)[pixel] = value;
    }
  }
  if constexpr (V::kInstances) {
    const u64 first = view.faces[3] + static_cast<u64>(face) * value_bytes<u32>(size);
    job.instances[pixel] = value_at<u32>(first, size, x, y);
  }
}

// --- Rows

/// A stretch of a row, ready to be drawn.
struct RowPiece {
  FaceLine line;
  u32 end;  ///< column
  u32 face;
};

/// What the threads of a block share.
struct Band {
  Crossing crossings[kCrossings];
  bool crosses[kCrossings];
  RowPiece pieces[kBandRows][kMostStretches];
};

EN_PIXELS void plan_band_row(const Rays& rays, u32 size, u32 width, u32 row, const Band& band,
                             RowPiece* pieces) {
  Crossing crossings[kCrossings];
  u32 count = 0;
  for (u32 k = 0; k < kCrossings; ++k) {
    if (band.crosses[k]) crossings[count++] = band.crossings[k];
  }
  Stretch stretches[kMostStretches];
  const u32 found = plan_row(crossings, count, rays, row, width, stretches);
  for (u32 k = 0; k < found; ++k) {
    pieces[k] = {face_line(rays, row, stretches[k].face, size), stretches[k].end,
                 stretches[k].face};
  }
}

/// A lane's stretch, and where its face is.
struct Cursor {
  RowPiece piece;
  u32 number;
  u64 colour;
};

template <class V>
EN_PIXELS void draw_row(const Job& job, const DeviceView& view, u64 number, u32 row,
                        const RowPiece* pieces) {
  const u32 size = view.sizes[job.size_layer];
  const u32 step = colour_pitch(size) - kRowBytes, face_bytes = colour_bytes(size);
  const u64 faces = view.faces[0];
  PerLane<Cursor> cursors;
  PerLane<u32> rgb;
  const auto go_to = [&](Cursor& cursor, u32 piece) {
    cursor = {pieces[piece], piece, faces + static_cast<u64>(pieces[piece].face) * face_bytes};
  };
  each_lane([&](u32 lane) { go_to(cursors[lane], 0); });

  const u64 view_pixels = static_cast<u64>(job.width) * job.height;
  const u32 place = row * job.width;
  constexpr u32 kBytes = colour_bytes_of(V::kColour);
  constexpr u32 kPlanes = V::kColour == kPlanar16 || V::kColour == kPlanar32 ? 3 : 1;
  u8* out = job.colour + kBytes * (kPlanes * number * view_pixels + place);
  const bool words = (static_cast<u32>(reinterpret_cast<u64>(out)) & 3) == 0;

  // Kept apart from the last columns of a row, so that whole groups of 32 ask nothing.
  const auto draw_group = [&](u32 first, u32 count, bool stores_words) {
    each_lane([&](u32 lane) {
      if (lane >= count) return;
      Cursor& cursor = cursors[lane];
      const u32 column = first + lane;
      while (column >= cursor.piece.end) go_to(cursor, cursor.number + 1);
      const TexelPoint p = texel_point(cursor.piece.line, static_cast<float>(column));
      if constexpr (V::kColour != kNoColour) {
        rgb[lane] = sample_colour(cursor.colour, step, V::kClamped ? clamped(p, size) : p);
      }
      if constexpr (V::kNearest) {
        const u64 pixel = number * view_pixels + place + column;
        draw_nearest<V>(job, view, cursor.piece.face, p, pixel, place + column);
      }
    });
    if constexpr (V::kColour != kNoColour) store_colour<V>(job, rgb, out, count, stores_words);
    out += kBytes * kLanes;
  };
  const u32 whole = job.width / kLanes * kLanes, rest = job.width - whole;
  for (u32 first = 0; first < whole; first += kLanes) draw_group(first, kLanes, words);
  if (rest > 0) draw_group(whole, rest, words && rest % 4 == 0);
}

// --- Blocks

#if defined(__CUDACC_RTC__)
template <class Each>
EN_PIXELS void each_thread(u32 count, const Each& each) {
  if (threadIdx.x < count) each(threadIdx.x);
  __syncthreads();
}
template <class Each>
EN_PIXELS void each_warp(const Each& each) {
  each(threadIdx.x / kLanes);
}
#else
template <class Each>
void each_thread(u32 count, const Each& each) {
  for (u32 thread = 0; thread < count; ++thread) each(thread);
}
template <class Each>
void each_warp(const Each& each) {
  for (u32 warp = 0; warp < kWarps; ++warp) each(warp);
}
#endif

/// Draws kBandRows rows of a view. \param block the view's number times job.bands, and the band's
template <class V>
EN_PIXELS void draw_band(const Job& job, u32 block, Band& band) {
  const u32 number = block / job.bands, first_row = block % job.bands * kBandRows;
  const u32 left = job.height - first_row, rows = left < kBandRows ? left : kBandRows;
  const DeviceView& view = job.views[number];
  each_thread(kCrossings,
              [&](u32 k) { band.crosses[k] = find_crossing(view.rays, k, band.crossings[k]); });
  each_thread(rows, [&](u32 k) {
    plan_band_row(view.rays, view.sizes[job.size_layer], job.width, first_row + k, band,
                  band.pieces[k]);
  });
  each_warp([&](u32 warp) {
    for (u32 k = warp; k < rows; k += kWarps) {
      draw_row<V>(job, view, number, first_row + k, band.pieces[k]);
    }
  });
}

/// From the cells of the CPU's colour faces (image/face_cells.h) to the strips above, one texel.
/// \param texel (face * rows + y) * columns + x, border included
EN_PIXELS void unpack_texel(const u8* cells, u8* strips, u32 size, u32 texel) {
  constexpr u32 kColumns = 18;
  const u32 edge = size + 2, x = texel % edge, y = texel / edge % edge, face = texel / edge / edge;
  const u32 cell = x / kColumns, pitch = 64 * edge;
  const u8* from = cells + static_cast<u64>(face) * ((size / kColumns + 1) * pitch) + cell * pitch +
                   y * 64 + (x - cell * kColumns) * 3;
  u8* to = strips + static_cast<u64>(face) * colour_bytes(size) +
           column_offset(x, colour_pitch(size) - kRowBytes) + y * kRowBytes;
  *reinterpret_cast<u32*>(to) =
      from[0] | static_cast<u32>(from[1]) << 8 | static_cast<u32>(from[2]) << 16;
}

}  // namespace enfilade::render::cuda

#if defined(__CUDACC_RTC__)
using namespace enfilade::render::cuda;

extern "C" __global__ void __launch_bounds__(kWarps* kLanes) draw(const Job job) {
  __shared__ Band band;
  draw_band<Variant<EN_COLOUR, EN_DEPTH, EN_CLASSES, EN_INSTANCES != 0, EN_CLAMPED != 0>>(
      job, blockIdx.x, band);
}

extern "C" __global__ void unpack(const u8* cells, u8* strips, u32 size, u32 texels) {
  const u32 texel = blockIdx.x * blockDim.x + threadIdx.x;
  if (texel < texels) unpack_texel(cells, strips, size, texel);
}
#endif
