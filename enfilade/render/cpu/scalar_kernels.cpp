// The scalar kernels: one pixel after another. The vector kernels are tested against them.
#include <cstring>

#include "enfilade/core/half.h"
#include "enfilade/render/cpu/kernels.h"
#include "enfilade/render/cpu/sampling.h"

namespace enfilade::render::cpu {
namespace {

void points(const FaceLine& line, std::uint32_t size, Piece piece, Points& out) {
  for (std::uint32_t k = 0; k < piece.size(); ++k) {
    const TexelPoint p = texel_point(line, size, piece.begin + k);
    out.x[k] = p.x;
    out.y[k] = p.y;
  }
}

void colour(const Points& points, const Face& face, bool clamped, std::size_t count,
            std::uint32_t* out) {
  const LinearRange range = linear_range(face.size, clamped);
  for (std::size_t k = 0; k < count; ++k) {
    out[k] = sample_colour(face, range, {points.x[k], points.y[k]});
  }
}

template <class T>
void nearest(const Points& points, const Face& face, std::size_t count, T* out) {
  for (std::size_t k = 0; k < count; ++k) {
    out[k] = sample_nearest<T>(face, {points.x[k], points.y[k]});
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

void stream(std::byte* out, const std::byte* from, std::size_t bytes) {
  std::memcpy(out, from, bytes);
}

void stream_end() {}

constexpr float kMetresPerUnit = 1.0F / static_cast<float>(scan::kDepthUnitsPerMetre);

float scaled(std::uint16_t units, float factor) { return static_cast<float>(units) * factor; }

void pack_metres(const std::uint16_t* units, const float* factor, std::size_t count, float* out) {
  for (std::size_t k = 0; k < count; ++k) out[k] = scaled(units[k], factor[k]) * kMetresPerUnit;
}

void pack_units(const std::uint16_t* units, const float* factor, std::size_t count,
                std::uint16_t* out) {
  for (std::size_t k = 0; k < count; ++k) {
    out[k] = static_cast<std::uint16_t>(scaled(units[k], factor[k]) + 0.5F);
  }
}

// Steps of an 8-bit colour buffer over the range of 16 bits.
std::uint32_t step257(std::uint16_t units, float factor) {
  return static_cast<std::uint32_t>(scaled(units, factor) * (1.0F / 257.0F) + 0.5F) * 257U;
}

void pack_legacy_units(const std::uint16_t* units, const float* factor, std::size_t count,
                       std::uint16_t* out) {
  for (std::size_t k = 0; k < count; ++k) {
    out[k] = static_cast<std::uint16_t>(step257(units[k], factor[k]));
  }
}

void pack_legacy_metres(const std::uint16_t* units, const float* factor, std::size_t count,
                        float* out) {
  for (std::size_t k = 0; k < count; ++k) {
    out[k] = static_cast<float>(step257(units[k], factor[k])) * kMetresPerUnit;
  }
}

constexpr Kernels kScalar{
    "scalar",   points,      colour,        nearest<std::uint16_t>, nearest<std::uint32_t>,
    pack_rgb,   pack_bgr,    pack_planar16, pack_planar32,          stream,
    stream_end, pack_metres, pack_units,    pack_legacy_units,      pack_legacy_metres,
};

}  // namespace

const Kernels& scalar_kernels() noexcept { return kScalar; }

}  // namespace enfilade::render::cpu
