// The plain twin: one pixel after another, no tricks. What the vector kernels are held against.
#include <cmath>
#include <cstring>

#include "enfilade/render/cpu/kernels.h"
#include "enfilade/render/cpu/sampling.h"

namespace enfilade::render::cpu {
namespace {

void colour(const FaceLine& line, const Face& face, bool clamped, Piece piece, std::uint32_t* out) {
  const TexelScale scale = linear_scale(face.size, clamped);
  for (std::uint32_t j = piece.begin; j < piece.end; ++j) {
    *out++ = sample_colour(face, texel_point(line, scale, j));
  }
}

template <class T>
void nearest(const FaceLine& line, const Face& face, Piece piece, T* out) {
  const TexelScale scale = nearest_scale(face.size);
  for (std::uint32_t j = piece.begin; j < piece.end; ++j) {
    *out++ = sample_nearest<T>(face, texel_point(line, scale, j));
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
    "scalar",
    colour,
    nearest<std::uint16_t>,
    nearest<std::uint32_t>,
    pack_rgb,
    pack_bgr,
    pack_planar16,
    pack_planar32,
    stream,
    stream_end,
    pack_metres,
    pack_units,
    pack_legacy_units,
    pack_legacy_metres,
};

}  // namespace

const Kernels& scalar_kernels() noexcept { return kScalar; }

}  // namespace enfilade::render::cpu
