/// \file  The kernels of the CUDA back end. NVRTC compiles this text, after detail/pixels.h, for
/// the card. As plain C++ it is its own twin, in which lanes, warps and blocks are loops
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

using namespace detail::pixels;  // NOLINT(google-build-using-namespace): one text, in two files

inline constexpr u32 kLanes = 32;     ///< per warp
inline constexpr u32 kWarps = 8;      ///< per block
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
  u32 bands;       ///< per view: ceil(height / kBandRows)
  u32 size_layer;  ///< the layer whose size of faces all drawn here have
  u8* colour;
  u8* depth;
  u8* classes;
  u32* instances;
  const float* depth_factors;  ///< one per pixel of a view
  float factor[3], offset[3];  ///< of planar colour
};

enum ColourKind : u32 { kNoColour, kRgb, kBgr, kRgba, kPlanar16, kPlanar32 };
enum DepthKind : u32 { kNoDepth, kMetres, kUnits, kLegacyMetres, kLegacyUnits };
enum ClassKind : u32 { kNoClasses, kClass8, kClass16 };

/// The outputs of a kernel. Clamped: colour is filtered within faces only.
template <u32 Colour, u32 Depth, u32 Classes, bool Instances, bool Clamped = false>
struct Variant {
  static constexpr u32 kColour = Colour, kDepth = Depth, kClasses = Classes;
  static constexpr bool kClamped = Clamped;
  static constexpr bool kInstances = Instances;
  static constexpr bool kNearest = Depth != kNoDepth || Classes != kNoClasses || Instances;
  // Drawing waits for texels most of the time, so as many warps as their registers allow. The
  // blocks that a multiprocessor should hold, and the groups of pixels under way in each, were
  // measured (docs/design/cuda.md).
  static constexpr u32 kBlocks = kNearest ? 6 : 8;
  static constexpr u32 kUnrolled = Colour == kPlanar16 || Colour == kPlanar32 ? 1 : 2;
};

// --- Colour on the card: strips of 16 texels of 4 bytes (R G B less 128, and one unused), border
// included. A strip's rows follow each other. So a line of 128 bytes holds 16 x 2 texels, the texel
// below is 64 bytes on, and a view turned by any angle reads few lines.

#if !defined(EN_STRIP_BITS)
#define EN_STRIP_BITS 4
#endif
inline constexpr u32 kStripBits = EN_STRIP_BITS;
inline constexpr u32 kRowBytes = 4U << kStripBits;

/// Bytes of a colour face.
EN_PIXELS u32 colour_bytes(u32 size) {
  return ((size + 2 + (1U << kStripBits) - 1) >> kStripBits) * kRowBytes * (size + 2);
}
// --- Lanes. On the card a thread is one lane; in the twin a loop runs all 32 through each step.

#if defined(__CUDACC_RTC__)
#define EN_PRAGMA(text) _Pragma(#text)
#define EN_UNROLLED(times) EN_PRAGMA(unroll times)
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
// The lower or the upper two bytes, with a sign, times two halves of a word without.
EN_PIXELS i32 products_low(u32 texels, u32 weights) {
  i32 sum;
  asm("dp2a.lo.u32.s32 %0, %1, %2, %3;" : "=r"(sum) : "r"(weights), "r"(texels), "r"(0));
  return sum;
}
EN_PIXELS i32 products_high(u32 texels, u32 weights) {
  i32 sum;
  asm("dp2a.hi.u32.s32 %0, %1, %2, %3;" : "=r"(sum) : "r"(weights), "r"(texels), "r"(0));
  return sum;
}
EN_PIXELS void store_if(bool stored, u8* out, u32 value) {
  asm volatile("{ .reg .pred p; setp.ne.u32 p, %2, 0; @p st.global.u32 [%0], %1; }" ::"l"(out),
               "r"(value), "r"(static_cast<u32>(stored))
               : "memory");
}
EN_PIXELS u16 half_of(float value) {
  u16 bits;
  asm("cvt.rn.f16.f32 %0, %1;" : "=h"(bits) : "f"(value));
  return bits;
}
// Loads from memory that the kernel does not write.
template <class T>
EN_PIXELS T load(const T* value) {
  return __ldg(value);
}
#else
#define EN_UNROLLED(times)
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
inline i32 products_low(u32 texels, u32 weights) {
  const auto texel = [&](u32 k) {
    return static_cast<i32>(static_cast<signed char>(texels >> 8 * k));
  };
  return texel(0) * static_cast<i32>(weights & 0xFFFF) + texel(1) * static_cast<i32>(weights >> 16);
}
inline i32 products_high(u32 texels, u32 weights) { return products_low(texels >> 16, weights); }
inline void store_if(bool stored, u8* out, u32 value) {
  if (stored) std::memcpy(out, &value, sizeof(value));
}
inline u16 half_of(float value) { return to_half(value); }
template <class T>
T load(const T* value) {
  return *value;
}
#endif

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
  return load(reinterpret_cast<const T*>(face + offset));
}

// --- Colour

/// Texels from a row's strip to the next one, less the strip's columns.
EN_PIXELS u32 strip_step(u32 size) { return (size + 1) << kStripBits; }
/// Number of a texel in its face. \param step strip_step()
EN_PIXELS u32 texel_number(u32 step, u32 x, u32 y) {
  return x + (y << kStripBits) + (x >> kStripBits) * step;
}

/// R, G, B in the lowest three bytes; bilinear, to the bit as cpu::sample_colour().
/// \param face its first texel  \param step strip_step() of its size
EN_PIXELS u32 sample_colour(const u32* face, u32 step, TexelPoint p) {
  const u32 x = static_cast<u32>(p.x), y = static_cast<u32>(p.y);
  // texel_number() of both, except the right one's place after the left one.
  const u32 row = (x >> 16) + (y >> 16 << kStripBits);
  const u32* left = face + (row + (x >> (16 + kStripBits)) * step);
  const u32* right = face + (row + ((x + 65536) >> (16 + kStripBits)) * step);
  const u32 top_left = load(left), top_right = load(right + 1);
  const u32 bottom_left = load(left + (1U << kStripBits));
  const u32 bottom_right = load(right + (1U << kStripBits) + 1);
  // Halves: the weights of left and right.
  const u32 across = 255 + 65535 * right_weight(p);
  const i32 lower = static_cast<i32>(lower_weight(p)), upper = kWholeWeight - lower;
  // R left, R right, G left, G right; B left, B right.
  const u32 top_rg = pick_bytes(top_left, top_right, 0x5140);
  const u32 bottom_rg = pick_bytes(bottom_left, bottom_right, 0x5140);
  const u32 top_b = pick_bytes(top_left, top_right, 0x0062);
  const u32 bottom_b = pick_bytes(bottom_left, bottom_right, 0x0062);
  // scale15(scale15(top, upper) + scale15(bottom, lower), 256) + 128. The sums of all roundings,
  // and the 128, are added at once: both are multiples of the bits cut off later.
  const auto channel = [&](i32 top, i32 bottom) {
    const i32 from_top = top * upper + ((1 << 14) + ((64 + (128 << 7)) << 15));
    const i32 from_bottom = bottom * lower + (1 << 14);
    return static_cast<u32>((from_top >> 15) + (from_bottom >> 15)) >> 7;
  };
  return channel(products_low(top_rg, across), products_low(bottom_rg, across)) |
         channel(products_high(top_rg, across), products_high(bottom_rg, across)) << 8 |
         channel(products_low(top_b, across), products_low(bottom_b, across)) << 16;
}

/// Bytes of a pixel, of one plane where there are three.
EN_PIXELS constexpr u32 colour_bytes_of(u32 kind) {
  return kind == kPlanar16 ? 2 : kind == kRgba || kind == kPlanar32 ? 4 : 3;
}

/// Pixels of 3 bytes of up to 32 lanes.
/// \param out where each lane's word goes  \param first where the first pixel goes
/// \param words whether that and `count` are multiples of 4
template <bool Swapped>
EN_PIXELS void store_bytes(PerLane<u32>& rgb, PerLane<u8*>& out, u8* first, u32 count, bool words) {
  if (Swapped) {
    each_lane([&](u32 lane) { rgb[lane] = pick_bytes(rgb[lane], 0, 0x4012); });
  }
  if (words) {
    // Lane k writes the k-th of the 24 words that 32 pixels fill.
    each_lane([&](u32 lane) {
      const u32 pixel = lane * 4 / 3, into = lane % 3;
      const u32 a = from_lane(rgb, pixel), b = from_lane(rgb, pixel + 1);
      const u32 selector = into == 0 ? 0x4210 : into == 1 ? 0x5421 : 0x6542;
      store_if(lane < count / 4 * 3, out[lane], pick_bytes(a, b, selector));
    });
  } else {
    each_lane([&](u32 lane) {
      if (lane >= count) return;
      for (u32 c = 0; c < 3; ++c) first[3 * lane + c] = static_cast<u8>(rgb[lane] >> 8 * c);
    });
  }
}

/// Bytes from a lane's place to the next lane's: of colours of 3 bytes, that of the word it writes.
EN_PIXELS constexpr u32 lane_bytes_of(u32 kind) { return colour_bytes_of(kind) == 2 ? 2 : 4; }

template <class V>
EN_PIXELS void store_colour(const Job& job, PerLane<u32>& rgb, PerLane<u8*>& out, u8* first,
                            u32 count, bool words) {
  if constexpr (V::kColour == kRgb || V::kColour == kBgr) {
    store_bytes<V::kColour == kBgr>(rgb, out, first, count, words);
  } else {
    const u64 plane = static_cast<u64>(job.width) * job.height;
    each_lane([&](u32 lane) {
      if (lane >= count) return;
      if constexpr (V::kColour == kRgba) {
        *reinterpret_cast<u32*>(out[lane]) = rgb[lane] | 0xFF000000U;
      } else {
        for (u32 c = 0; c < 3; ++c) {
          const float value =
              static_cast<float>(rgb[lane] >> 8 * c & 255) * job.factor[c] + job.offset[c];
          if constexpr (V::kColour == kPlanar16) {
            reinterpret_cast<u16*>(out[lane])[c * plane] = half_of(value);
          } else {
            reinterpret_cast<float*>(out[lane])[c * plane] = value;
          }
        }
      }
    });
  }
}

// --- Depth, classes and instances of one pixel

/// Where a lane's values go.
struct NearestOut {
  u8* depth;
  u8* classes;
  u32* instances;
  const float* factor;  ///< of depth
};

template <class V>
EN_PIXELS constexpr u32 depth_bytes() {
  return V::kDepth == kMetres || V::kDepth == kLegacyMetres ? 4 : 2;
}
template <class V>
EN_PIXELS constexpr u32 class_bytes() {
  return V::kClasses == kClass8 ? 1 : 2;
}

/// \param pixel in the batch  \param place in its view
template <class V>
EN_PIXELS NearestOut nearest_out(const Job& job, u64 pixel, u32 place) {
  NearestOut out{};
  if constexpr (V::kDepth != kNoDepth) {
    out.depth = job.depth + depth_bytes<V>() * pixel;
    out.factor = job.depth_factors + place;
  }
  if constexpr (V::kClasses != kNoClasses) out.classes = job.classes + class_bytes<V>() * pixel;
  if constexpr (V::kInstances) out.instances = job.instances + pixel;
  return out;
}

template <class V>
EN_PIXELS void go_on(NearestOut& out) {
  if constexpr (V::kDepth != kNoDepth) {
    out.depth += depth_bytes<V>() * kLanes;
    out.factor += kLanes;
  }
  if constexpr (V::kClasses != kNoClasses) out.classes += class_bytes<V>() * kLanes;
  if constexpr (V::kInstances) out.instances += kLanes;
}

template <class V>
EN_PIXELS void store_depth(u16 units, const NearestOut& out) {
  const float value = scaled(units, *out.factor);
  if constexpr (V::kDepth == kMetres) {
    *reinterpret_cast<float*>(out.depth) = value * kMetresPerUnit;
  } else if constexpr (V::kDepth == kUnits) {
    *reinterpret_cast<u16*>(out.depth) = rounded(value);
  } else if constexpr (V::kDepth == kLegacyMetres) {
    *reinterpret_cast<float*>(out.depth) = static_cast<float>(step257(value)) * kMetresPerUnit;
  } else {
    *reinterpret_cast<u16*>(out.depth) = static_cast<u16>(step257(value));
  }
}

/// Addresses of a face in the layers of the nearest texel.
struct NearestFaces {
  u64 depth, classes, instances;
};

template <class V>
EN_PIXELS NearestFaces nearest_faces(const DeviceView& view, u32 size, u32 face) {
  NearestFaces faces{};
  if constexpr (V::kDepth != kNoDepth) {
    faces.depth = view.faces[1] + static_cast<u64>(face) * value_bytes<u16>(size);
  }
  if constexpr (V::kClasses != kNoClasses) {
    faces.classes = view.faces[2] + static_cast<u64>(face) * value_bytes<u16>(size);
  }
  if constexpr (V::kInstances) {
    faces.instances = view.faces[3] + static_cast<u64>(face) * value_bytes<u32>(size);
  }
  return faces;
}

template <class V>
EN_PIXELS void draw_nearest(const NearestFaces& faces, u32 size, TexelPoint p,
                            const NearestOut& out) {
  const u32 x = nearest_texel(p.x, size), y = nearest_texel(p.y, size);
  if constexpr (V::kDepth != kNoDepth) store_depth<V>(value_at<u16>(faces.depth, size, x, y), out);
  if constexpr (V::kClasses != kNoClasses) {
    const u16 value = value_at<u16>(faces.classes, size, x, y);
    if constexpr (V::kClasses == kClass8) {
      *out.classes = static_cast<u8>(value > 255 ? 255 : value);
    } else {
      *reinterpret_cast<u16*>(out.classes) = value;
    }
  }
  if constexpr (V::kInstances) *out.instances = value_at<u32>(faces.instances, size, x, y);
}

// --- Rows

/// A stretch of a row, ready to be drawn.
struct RowPiece {
  FaceLine line;
  u32 end_and_face;   ///< its end, a column, times 8, and the face
  u32 colour_texels;  ///< from the panorama's first colour texel to the face's
};
EN_PIXELS u32 end_of(const RowPiece& piece) { return piece.end_and_face >> 3; }

/// The data that the threads of a block share.
struct Band {
  Crossing crossings[kCrossings];
  RowPiece pieces[kBandRows][kMostStretches];
};

EN_PIXELS void plan_band_row(const Rays& rays, u32 size, u32 width, u32 row, const Band& band,
                             RowPiece* pieces) {
  const u32 face_texels = colour_bytes(size) / 4;
  plan_row(band.crossings, rays, row, width, [&](const RowStretch& stretch) {
    *pieces++ = {face_line(rays, row, stretch.face, size), stretch.end << 3 | stretch.face,
                 stretch.face * face_texels};
  });
}

/// The face that a lane draws from.
struct LaneFace {
  FaceLine line;
  const u32* colour;
  NearestFaces nearest;
};

template <class V>
EN_PIXELS LaneFace lane_face(const DeviceView& view, u32 size, const RowPiece& piece) {
  return {piece.line, reinterpret_cast<const u32*>(view.faces[0]) + piece.colour_texels,
          nearest_faces<V>(view, size, piece.end_and_face & 7)};
}

template <class V>
EN_PIXELS void draw_row(const Job& job, const DeviceView& view, u64 number, u32 row,
                        const RowPiece* pieces) {
  const u32 size = view.sizes[job.size_layer], step = strip_step(size);
  const u64 view_pixels = static_cast<u64>(job.width) * job.height;
  const u32 row_place = row * job.width;
  constexpr u32 kBytes = colour_bytes_of(V::kColour);
  constexpr u32 kPlanes = V::kColour == kPlanar16 || V::kColour == kPlanar32 ? 3 : 1;
  u8* const row_colour = job.colour + kBytes * (kPlanes * number * view_pixels + row_place);
  const bool words = (static_cast<u32>(reinterpret_cast<u64>(row_colour)) & 3) == 0;

  PerLane<LaneFace> faces;
  PerLane<float> columns;
  PerLane<u32> rgb;
  PerLane<u8*> colour;
  PerLane<NearestOut> nearest;
  each_lane([&](u32 lane) {
    columns[lane] = static_cast<float>(lane);
    colour[lane] = row_colour + lane_bytes_of(V::kColour) * lane;
    nearest[lane] = nearest_out<V>(job, number * view_pixels + row_place + lane, row_place + lane);
  });
  const auto draw_group = [&](u32 first, u32 count, bool stores_words) {
    each_lane([&](u32 lane) {
      if (lane < count) {
        const TexelPoint p = texel_point(faces[lane].line, columns[lane]);
        if constexpr (V::kColour != kNoColour) {
          rgb[lane] = sample_colour(faces[lane].colour, step, V::kClamped ? clamped(p, size) : p);
        }
        if constexpr (V::kNearest) draw_nearest<V>(faces[lane].nearest, size, p, nearest[lane]);
      }
      columns[lane] += static_cast<float>(kLanes);
    });
    if constexpr (V::kColour != kNoColour) {
      store_colour<V>(job, rgb, colour, row_colour + kBytes * first, count, stores_words);
    }
    each_lane([&](u32 lane) {
      colour[lane] += kBytes * kLanes;
      go_on<V>(nearest[lane]);
    });
  };

  // The lanes' faces, from a column on; they hold until `held_until`, for as many groups as lie
  // before it.
  u32 piece = 0, held_until = 0;
  const auto take_faces = [&](u32 first) {
    while (end_of(pieces[piece]) <= first) ++piece;
    const u32 end = end_of(pieces[piece]);
    each_lane([&](u32 lane) {
      u32 own = piece;
      for (const u32 column = first + lane; column < job.width && column >= end_of(pieces[own]);)
        ++own;
      faces[lane] = lane_face<V>(view, size, pieces[own]);
    });
    held_until = end < first + kLanes ? first + kLanes : end;
  };
  const u32 whole = words ? job.width / kLanes * kLanes : 0;
  u32 first = 0;
  EN_UNROLLED((V::kUnrolled))
  for (; first < whole; first += kLanes) {
    if (first + kLanes > held_until) take_faces(first);
    draw_group(first, kLanes, true);
  }
  EN_UNROLLED(1)
  for (; first < job.width; first += kLanes) {
    const u32 left = job.width - first, count = left < kLanes ? left : kLanes;
    if (first + kLanes > held_until) take_faces(first);
    draw_group(first, count, words && count % 4 == 0);
  }
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
  each_thread(kCrossings, [&](u32 k) { band.crossings[k] = find_crossing(view.rays, k); });
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
  const u64 first = reinterpret_cast<u64>(strips) + static_cast<u64>(face) * colour_bytes(size);
  const u64 to = first + 4ULL * texel_number(strip_step(size), x, y);
  *reinterpret_cast<u32*>(to) =
      from[0] | static_cast<u32>(from[1]) << 8 | static_cast<u32>(from[2]) << 16;
}

}  // namespace enfilade::render::cuda

#if defined(__CUDACC_RTC__)
using namespace enfilade::render::cuda;

using Wanted = Variant<EN_COLOUR, EN_DEPTH, EN_CLASSES, EN_INSTANCES != 0, EN_CLAMPED != 0>;

extern "C" __global__ void __launch_bounds__(kWarps* kLanes, Wanted::kBlocks) draw(const Job job) {
  __shared__ Band band;
  draw_band<Wanted>(job, blockIdx.x, band);
}

extern "C" __global__ void unpack(const u8* cells, u8* strips, u32 size, u32 texels) {
  const u32 texel = blockIdx.x * blockDim.x + threadIdx.x;
  if (texel < texels) unpack_texel(cells, strips, size, texel);
}
#endif
