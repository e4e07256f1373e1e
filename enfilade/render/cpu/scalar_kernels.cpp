// The scalar kernels: one pixel after another. The vector kernels are tested against them.
#include <cstring>

#include "enfilade/core/half.h"
#include "enfilade/render/cpu/kernels.h"
#include "enfilade/render/cpu/row_plan.h"

namespace enfilade::render::cpu {
namespace {

void points(const FaceLine& line, PixelRange piece, std::size_t at, Points& out) {
  for (std::uint32_t column = piece.begin; column < piece.end; ++column, ++at) {
    const TexelPoint p = texel_point(line, column);
    out.x[at] = p.x;
    out.y[at] = p.y;
  }
}

void taps(const Ahead& ahead) {
  for (const TapPart& part : ahead.parts) {
    for (std::uint32_t k = 0; k < part.piece.size(); ++k) {
      const TexelPoint p = texel_point(part.line, part.piece.begin + k);
      const Tap tap = tap_at(part.face.size, part.face.clamped, p);
      ahead.taps.offset[part.at + k] = part.face.first + tap.offset;
      ahead.taps.weights[part.at + k] = tap.weights;
    }
    if (ahead.points != nullptr) points(part.line, part.piece, part.at, *ahead.points);
  }
}

template <class T>
void places(const Points& points, std::size_t from, std::size_t count, const NearestFace& face,
            Places& out) {
  for (std::size_t k = from; k < from + count; ++k) {
    out.offset[k] = face.first + nearest_offset<T>(face.size, {points.x[k], points.y[k]});
  }
}

template <class T>
void values(const PlaceRun& run, T* out) {
  for (std::size_t k = 0; k < run.count; ++k) {
    std::memcpy(out + k, run.base + run.places.offset[run.from + k], sizeof(T));
  }
}

std::uint8_t channel(std::uint32_t rgba, unsigned c) {
  return static_cast<std::uint8_t>(rgba >> (8 * c));
}

void pack_rgb(const std::uint32_t* rgba, std::size_t count, std::uint8_t* out) {
  for (std::size_t k = 0; k < count; ++k) {
    for (unsigned c = 0; c < 3; ++c) *out++ = channel(rgba[k], c);
  }
}

void pack_bgr(const std::uint32_t* rgba, std::size_t count, std::uint8_t* out) {
  for (std::size_t k = 0; k < count; ++k) {
    for (unsigned c = 0; c < 3; ++c) *out++ = channel(rgba[k], 2 - c);
  }
}

float planar(std::uint32_t rgba, unsigned c, const PlanarScale& scale) {
  return static_cast<float>(channel(rgba, c)) * scale.factor[c] + scale.offset[c];
}

void pack_planar16(const std::uint32_t* rgba, std::size_t count, const PlanarScale& scale,
                   std::size_t plane, std::uint16_t* out) {
  for (unsigned c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < count; ++k) {
      out[c * plane + k] = to_half(planar(rgba[k], c, scale));
    }
  }
}

void pack_planar32(const std::uint32_t* rgba, std::size_t count, const PlanarScale& scale,
                   std::size_t plane, float* out) {
  for (unsigned c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < count; ++k) out[c * plane + k] = planar(rgba[k], c, scale);
  }
}

// Hands the pixels of a run to what packs them.
template <class Pack>
void draw(const TapRun& run, const Ahead& ahead, const Pack& pack) {
  taps(ahead);
  for (std::size_t k = 0; k < run.count; ++k) {
    const std::size_t at = run.from + k;
    pack(sample_colour(run.base, {run.taps.offset[at], run.taps.weights[at]}), k);
  }
}

void draw_rgb(const TapRun& run, const Ahead& ahead, std::uint8_t* out) {
  draw(run, ahead, [&](std::uint32_t rgba, std::size_t k) { pack_rgb(&rgba, 1, out + 3 * k); });
}

void draw_bgr(const TapRun& run, const Ahead& ahead, std::uint8_t* out) {
  draw(run, ahead, [&](std::uint32_t rgba, std::size_t k) { pack_bgr(&rgba, 1, out + 3 * k); });
}

void draw_rgba(const TapRun& run, const Ahead& ahead, std::uint32_t* out) {
  draw(run, ahead, [&](std::uint32_t rgba, std::size_t k) { out[k] = rgba; });
}

void draw_planar16(const TapRun& run, const Ahead& ahead, const PlanarScale& scale,
                   std::size_t plane, std::uint16_t* out) {
  draw(run, ahead,
       [&](std::uint32_t rgba, std::size_t k) { pack_planar16(&rgba, 1, scale, plane, out + k); });
}

void draw_planar32(const TapRun& run, const Ahead& ahead, const PlanarScale& scale,
                   std::size_t plane, float* out) {
  draw(run, ahead,
       [&](std::uint32_t rgba, std::size_t k) { pack_planar32(&rgba, 1, scale, plane, out + k); });
}

void stream(std::byte* out, const std::byte* from, std::size_t bytes) {
  std::memcpy(out, from, bytes);
}

void stream_end() {}

using pixels::kMetresPerUnit;
using pixels::scaled;
static_assert(kMetresPerUnit == 1.0F / static_cast<float>(scan::kDepthUnitsPerMetre));

void pack_metres(const std::uint16_t* units, const float* factor, std::size_t count, float* out) {
  for (std::size_t k = 0; k < count; ++k) out[k] = scaled(units[k], factor[k]) * kMetresPerUnit;
}

void pack_units(const std::uint16_t* units, const float* factor, std::size_t count,
                std::uint16_t* out) {
  for (std::size_t k = 0; k < count; ++k) {
    out[k] = pixels::rounded(scaled(units[k], factor[k]));
  }
}

void draw_metres(const PlaceRun& run, const float* factor, float* out) {
  Block16 units;
  values(run, units.values.data());
  pack_metres(units.values.data(), factor, run.count, out);
}

void draw_units(const PlaceRun& run, const float* factor, std::uint16_t* out) {
  Block16 units;
  values(run, units.values.data());
  pack_units(units.values.data(), factor, run.count, out);
}

void pack_legacy_units(const std::uint16_t* units, const float* factor, std::size_t count,
                       std::uint16_t* out) {
  for (std::size_t k = 0; k < count; ++k) {
    out[k] = static_cast<std::uint16_t>(pixels::step257(scaled(units[k], factor[k])));
  }
}

void pack_legacy_metres(const std::uint16_t* units, const float* factor, std::size_t count,
                        float* out) {
  for (std::size_t k = 0; k < count; ++k) {
    out[k] = static_cast<float>(pixels::step257(scaled(units[k], factor[k]))) * kMetresPerUnit;
  }
}

constexpr PixelKernels kScalar{
    .points = points,
    .taps = taps,
    .draw_rgb = draw_rgb,
    .draw_bgr = draw_bgr,
    .draw_rgba = draw_rgba,
    .draw_planar16 = draw_planar16,
    .draw_planar32 = draw_planar32,
    .places16 = places<std::uint16_t>,
    .places32 = places<std::uint32_t>,
    .values16 = values<std::uint16_t>,
    .values32 = values<std::uint32_t>,
    .draw_metres = draw_metres,
    .draw_units = draw_units,
    .pack_rgb = pack_rgb,
    .pack_bgr = pack_bgr,
    .pack_planar16 = pack_planar16,
    .pack_planar32 = pack_planar32,
    .stream = stream,
    .stream_end = stream_end,
    .pack_metres = pack_metres,
    .pack_units = pack_units,
    .pack_legacy_units = pack_legacy_units,
    .pack_legacy_metres = pack_legacy_metres,
};

}  // namespace

const PixelKernels& scalar_kernels() noexcept { return kScalar; }

}  // namespace enfilade::render::cpu
