/// \file  The texels of a pixel in the faces of a cube, and their weights. This is the arithmetic
/// that all back ends share, one function per step. Freestanding: the CPU's code includes it, and
/// the CUDA back end compiles the same text for the card, without any header. Nothing here may be
/// contracted into fused operations, or pictures would differ in bits (docs/design/kernels.md).
#pragma once
#if defined(__CUDACC_RTC__)
#define EN_PIXELS static __device__ __forceinline__
#else
#include <cmath>
#define EN_PIXELS inline
#endif

namespace enfilade::render::detail::pixels {

#if !defined(__CUDACC_RTC__)
using std::ceil;
using std::fabs;
using std::floor;
#endif

// NOLINTBEGIN(google-runtime-int, readability-identifier-naming): a card's compiler knows no
// <cstdint>, and formulas of bits are read by their widths.
using i32 = int;
using u8 = unsigned char;
using u16 = unsigned short;
using u32 = unsigned int;
using u64 = unsigned long long;
// NOLINTEND(google-runtime-int, readability-identifier-naming)

/// As enfilade::Vec3d, without its header.
struct Vector {
  double x, y, z;
};
/// As enfilade::PixelRays.
struct Rays {
  Vector origin, row, column;
};

EN_PIXELS double part_of(const Vector& v, u32 part) {
  return part == 0 ? v.x : part == 1 ? v.y : v.z;
}

/// The ray of row i and column j, not normalised.
EN_PIXELS Vector ray_at(const Rays& rays, double i, double j) {
  return {rays.origin.x + i * rays.row.x + j * rays.column.x,
          rays.origin.y + i * rays.row.y + j * rays.column.y,
          rays.origin.z + i * rays.row.z + j * rays.column.z};
}

/// enfilade::face_towards(), as index(CubeFace).
EN_PIXELS u32 face_towards(const Vector& d) {
  const double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
  if (y >= x && y >= z) return d.y < 0 ? 0 : 5;
  if (x >= z) return d.x < 0 ? 2 : 4;
  return d.z < 0 ? 1 : 3;
}

/// A row's pixels projected to a face. For column j, with D = d0 + j d1, the pixel's point on the
/// face is ((x0 + j x1) / D, (y0 + j y1) / D). The unit is 65536ths of a texel from the middle of
/// the first texel of the face's border. D is positive where the face is met. Single precision: all
/// kernels compute in it, so that they agree to the bit.
struct FaceLine {
  float x0, x1, y0, y1, d0, d1;
};

/// Which part of a direction lies along an axis of a face (kFaceAxes), and its sign there.
struct AxisPart {
  u32 part;
  double sign;
};
/// \param face index(CubeFace)  \param axis 0: right, 1: down, 2: forward
EN_PIXELS AxisPart axis_part(u32 face, u32 axis) {
  // Two bits a part and one a sign, axes and then faces from the right: tables would lie in a
  // card's slow memory.
  constexpr u64 kParts = 0x606906918ULL;
  constexpr u32 kNegative = 0x912FU;
  const u32 place = 3 * face + axis;
  return {static_cast<u32>(kParts >> 2 * place) & 3U, (kNegative >> place & 1U) != 0 ? -1.0 : 1.0};
}

/// \param face index(CubeFace)  \param size of the face, in texels
EN_PIXELS FaceLine face_line(const Rays& rays, u32 row, u32 face, u32 size) {
  const Vector origin = ray_at(rays, row, 0);
  const double half = size * 32768.0, middle = half + 32768.0;
  const auto start = [&](u32 axis) {
    const AxisPart at = axis_part(face, axis);
    return at.sign * part_of(origin, at.part);
  };
  const auto step = [&](u32 axis) {
    const AxisPart at = axis_part(face, axis);
    return at.sign * part_of(rays.column, at.part);
  };
  const double d0 = start(2), d1 = step(2);
  return {static_cast<float>(start(0) * half + d0 * middle),
          static_cast<float>(step(0) * half + d1 * middle),
          static_cast<float>(start(1) * half + d0 * middle),
          static_cast<float>(step(1) * half + d1 * middle),
          static_cast<float>(d0),
          static_cast<float>(d1)};
}

/// Rows begin .. end - 1.
struct RowBand {
  u32 begin, end;
};

/// The columns origin + row * slope at which two parts of the direction are of equal size. Also the
/// rows in which the third part is not larger; in the others no face ends there.
struct Crossing {
  double origin, slope;
  RowBand rows[2];
};
inline constexpr u32 kCrossings = 6;

inline constexpr double kMostRows = 2147483648.0;

EN_PIXELS u32 row_number(double row) {
  return static_cast<u32>(row < 0 ? 0 : row > kMostRows ? kMostRows : row);
}

// The rows in which |part| <= |limit|, and perhaps one more at each end. A needless cut does no
// harm, and rounding must not hide a corner, where both are equal.
EN_PIXELS void rows_within(double part0, double part1, double limit0, double limit1,
                           RowBand rows[2]) {
  const double origins[2] = {limit0 - part0, limit0 + part0};
  const double slopes[2] = {limit1 - part1, limit1 + part1};
  double low = slopes[0] != 0 ? -origins[0] / slopes[0] : 0;
  double high = slopes[1] != 0 ? -origins[1] / slopes[1] : 0;
  if (high < low) {
    const double between = low;
    low = high;
    high = between;
  }
  const double ends[4] = {low < 0 ? low : 0, low < 0 ? (high < 0 ? high : 0) : low,
                          high < 0 ? 0 : (high > kMostRows ? kMostRows : high),
                          high > kMostRows ? high : kMostRows};
  rows[0] = rows[1] = {0, 0};
  u32 count = 0;
  for (u32 k = 0; k < 3; ++k) {
    const double begin = ends[k] < 0 ? 0 : ends[k];
    const double end = ends[k + 1] > kMostRows ? kMostRows : ends[k + 1];
    const double middle = begin + (end - begin) / 2;
    const double product = (origins[0] + middle * slopes[0]) * (origins[1] + middle * slopes[1]);
    if (begin > end || product < 0) continue;
    const RowBand found = {row_number(floor(begin) - 1), row_number(ceil(end) + 2)};
    if (count > 0 && found.begin <= rows[count - 1].end) {
      rows[count - 1].end = found.end;
    } else {
      rows[count++] = found;
    }
  }
}

/// The crossing of one of the pairs of planes in which faces meet: a = b or a = -b. Here a is a
/// part of the direction and b the next one. Without rows if no row crosses it.
/// \pre number < kCrossings
EN_PIXELS Crossing find_crossing(const Rays& rays, u32 number) {
  Crossing out = {0, 0, {{0, 0}, {0, 0}}};
  const u32 a = number / 2, b = (a + 1) % 3, c = (a + 2) % 3;
  const double sign = number % 2 == 0 ? 1.0 : -1.0;
  const double slope = part_of(rays.column, a) - sign * part_of(rays.column, b);
  if (slope == 0) return out;
  out.origin = -(part_of(rays.origin, a) - sign * part_of(rays.origin, b)) / slope;
  out.slope = -(part_of(rays.row, a) - sign * part_of(rays.row, b)) / slope;
  rows_within(part_of(rays.origin, c) + out.origin * part_of(rays.column, c),
              part_of(rays.row, c) + out.slope * part_of(rays.column, c),
              part_of(rays.origin, a) + out.origin * part_of(rays.column, a),
              part_of(rays.row, a) + out.slope * part_of(rays.column, a), out.rows);
  return out;
}

/// Columns begin .. end - 1 of a row, which meet one face.
struct RowStretch {
  u32 begin, end;
  u32 face;  ///< index(CubeFace)
};
/// Pieces of a row between six crossings.
inline constexpr u32 kMostStretches = 7;

EN_PIXELS bool has_row(const RowBand& rows, u32 row) { return row >= rows.begin && row < rows.end; }

/// enfilade::project_to_cube() for a whole row: calls take(RowStretch) from left to right.
/// \param crossings kCrossings of them
template <class Take>
EN_PIXELS void plan_row(const Crossing* crossings, const Rays& rays, u32 row, u32 width,
                        const Take& take) {
  u32 cuts[kCrossings + 1];
  cuts[0] = 0;
  u32 n = 1;
  for (u32 k = 0; k < kCrossings; ++k) {
    const Crossing& crossing = crossings[k];
    if (!has_row(crossing.rows[0], row) && !has_row(crossing.rows[1], row)) continue;
    const double column = crossing.origin + row * crossing.slope;
    if (!(column > 0 && column < width)) continue;
    u32 cut = static_cast<u32>(column);
    if (cut < column) ++cut;
    // Kept in order: six numbers at most, too few for a sorting function.
    u32 place = n++;
    for (; cuts[place - 1] > cut; --place) cuts[place] = cuts[place - 1];
    cuts[place] = cut;
  }
  RowStretch stretch = {0, 0, 0};  // not taken yet, as the next piece may be on the same face
  for (u32 k = 0; k < n; ++k) {
    const u32 begin = cuts[k], end = k + 1 < n ? cuts[k + 1] : width;
    if (begin >= end) continue;
    const u32 face = face_towards(ray_at(rays, row, begin + (end - begin) / 2));
    if (stretch.end > 0 && stretch.face != face) take(stretch);
    stretch = {stretch.end > 0 && stretch.face == face ? stretch.begin : begin, end, face};
  }
  if (stretch.end > 0) take(stretch);
}

/// A point of a face in 65536ths of a texel from the middle of the first texel of its border. The
/// upper 16 bits are a texel's number, the lower the position between it and the next. Points of
/// the face itself are at least half a texel inside the range, so rounding needs no clamp.
struct TexelPoint {
  i32 x, y;
};

/// 1 / x, rounded to nearest. \pre x and 1 / x are normal numbers
EN_PIXELS float reciprocal(float x) {
#if defined(__CUDACC_RTC__)
  // The compiler's own division, without its check for numbers that are not normal.
  float guess;
  asm("rcp.approx.ftz.f32 %0, %1;" : "=f"(guess) : "f"(x));
  return __fmaf_rn(guess, -__fmaf_rn(x, guess, -1.0F), guess);
#else
  return 1.0F / x;
#endif
}

/// \param column a whole number
EN_PIXELS TexelPoint texel_point(const FaceLine& line, float column) {
  const float inverse = reciprocal(line.d0 + column * line.d1);
  return {static_cast<i32>((line.x0 + column * line.x1) * inverse),
          static_cast<i32>((line.y0 + column * line.y1) * inverse)};
}

/// No farther than to the middles of a face's outer texels.
EN_PIXELS TexelPoint clamped(TexelPoint p, u32 size) {
  const i32 first = 65536, last = static_cast<i32>(size << 16);
  return {p.x < first  ? first
          : p.x > last ? last
                       : p.x,
          p.y < first  ? first
          : p.y > last ? last
                       : p.y};
}

/// (a * b) / 2^15, rounded to nearest: what one vector instruction does to 16-bit numbers.
EN_PIXELS i32 scale15(i32 a, i32 b) { return (a * b + (1 << 14)) >> 15; }

/// All that the upper and the lower texels weigh: 2^15 * 128 / 255, rounded.
inline constexpr i32 kWholeWeight = 16448;
/// Weight of the right texels, of 255 in all.
EN_PIXELS u32 right_weight(TexelPoint p) {
#if defined(__CUDACC_RTC__)
  return __byte_perm(static_cast<u32>(p.x), 0, 0x4441);  // one instruction for two
#else
  return static_cast<u32>(p.x) >> 8 & 255;
#endif
}
/// Weight of the lower texels, of kWholeWeight in all: scale15((y & 0xFFFF) >> 1, kWholeWeight),
/// with 64 = kWholeWeight / 257 taken out.
EN_PIXELS u32 lower_weight(TexelPoint p) {
  static_assert(kWholeWeight == 64 * 257);
  return (static_cast<u32>(p.y & 0xFFFE) * 257 + 512) >> 10;
}

/// The column or row of the texel that holds a coordinate, of a face without border.
EN_PIXELS u32 nearest_texel(i32 coordinate, u32 size) {
  // From the middle of the border's texel to the face's edge; beyond are rounding errors.
  const i32 last = static_cast<i32>(size << 16) - 1, c = coordinate - 32768;
  return static_cast<u32>(c < 0 ? 0 : c > last ? last : c) >> 16;
}

inline constexpr float kMetresPerUnit = 1.0F / 4000.0F;  ///< of depth's texels

/// A texel's depth in the measure that a pixel's factor makes of it, in its units.
EN_PIXELS float scaled(u16 units, float factor) { return static_cast<float>(units) * factor; }
EN_PIXELS u16 rounded(float units) { return static_cast<u16>(static_cast<u32>(units + 0.5F)); }
/// In steps of an 8-bit colour buffer over the range of 16 bits.
EN_PIXELS u32 step257(float units) {
  return static_cast<u32>(units * (1.0F / 257.0F) + 0.5F) * 257U;
}

}  // namespace enfilade::render::detail::pixels
