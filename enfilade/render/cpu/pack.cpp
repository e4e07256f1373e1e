#include "enfilade/render/cpu/pack.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace enfilade::render::cpu {
namespace {

template <class T>
T* values_at(std::span<std::byte> pixels, std::size_t first) {
  return reinterpret_cast<T*>(pixels.data()) + first;
}

// Lets `pack` write `count` values to `out`, straight or through a buffer in the first cache.
template <class T, class Pack>
void put(const Kernels& kernels, bool stream, T* out, std::size_t count, const Pack& pack) {
  if (!stream) return pack(out);
  alignas(64) std::array<T, 4 * kBlock> buffer;
  pack(buffer.data());
  kernels.stream(reinterpret_cast<std::byte*>(out),
                 reinterpret_cast<const std::byte*>(buffer.data()), count * sizeof(T));
}

// A block's three planes.
template <class T, class Pack>
void put_planes(const Kernels& kernels, const Place& place, T* out, const Pack& pack) {
  if (!place.stream) return pack(out, place.pixels);
  alignas(64) std::array<T, 3 * kBlock> buffer;
  pack(buffer.data(), kBlock);
  for (std::size_t c = 0; c < 3; ++c) {
    kernels.stream(reinterpret_cast<std::byte*>(out + c * place.pixels),
                   reinterpret_cast<const std::byte*>(buffer.data() + c * kBlock),
                   place.count * sizeof(T));
  }
}

}  // namespace

PlanarScale planar_scale(const Normalisation& normalisation) noexcept {
  PlanarScale scale{};
  for (std::size_t c = 0; c < 3; ++c) {
    scale.factor[c] = 1.0F / (255.0F * normalisation.deviation[c]);
    scale.offset[c] = -normalisation.mean[c] / normalisation.deviation[c];
  }
  return scale;
}

void pack_colour(const Kernels& kernels, const ColourOutput& output, const PlanarScale& scale,
                 const std::uint32_t* rgba, const Place& place) {
  const std::size_t pixel = place.view * place.pixels + place.first;
  const std::size_t planar = 3 * place.view * place.pixels + place.first;
  const auto interleaved = [&](auto pack) {
    put(kernels, place.stream, values_at<std::uint8_t>(output.pixels, 3 * pixel), 3 * place.count,
        [&](std::uint8_t* out) { pack(rgba, place.count, out); });
  };
  switch (output.format) {
    case ColourFormat::kRgb8:
      return interleaved(kernels.pack_rgb);
    case ColourFormat::kBgr8:
      return interleaved(kernels.pack_bgr);
    case ColourFormat::kRgba8:
      std::memcpy(output.pixels.data() + 4 * pixel, rgba, 4 * place.count);
      return;
    case ColourFormat::kPlanarFloat16:
      return put_planes(kernels, place, values_at<std::uint16_t>(output.pixels, planar),
                        [&](std::uint16_t* out, std::size_t plane) {
                          kernels.pack_planar16(rgba, place.count, scale, plane, out);
                        });
    case ColourFormat::kPlanarFloat32:
      return put_planes(kernels, place, values_at<float>(output.pixels, planar),
                        [&](float* out, std::size_t plane) {
                          kernels.pack_planar32(rgba, place.count, scale, plane, out);
                        });
  }
}

void pack_depth(const Kernels& kernels, const DepthOutput& output, bool eight_bit,
                const std::uint16_t* units, const float* factor, const Place& place) {
  const std::size_t pixel = place.view * place.pixels + place.first;
  const auto with = [&](auto pack, auto* out) {
    put(kernels, place.stream, out, place.count,
        [&](auto* to) { pack(units, factor, place.count, to); });
  };
  if (output.format == DepthFormat::kMetresFloat32) {
    with(eight_bit ? kernels.pack_legacy_metres : kernels.pack_metres,
         values_at<float>(output.pixels, pixel));
  } else {
    with(eight_bit ? kernels.pack_legacy_units : kernels.pack_units,
         values_at<std::uint16_t>(output.pixels, pixel));
  }
}

void pack_classes(const ClassOutput& output, const std::uint16_t* values, const Place& place) {
  const std::size_t pixel = place.view * place.pixels + place.first;
  if (output.format == ClassFormat::kUint16) {
    std::memcpy(output.pixels.data() + 2 * pixel, values, 2 * place.count);
    return;
  }
  auto* out = values_at<std::uint8_t>(output.pixels, pixel);
  for (std::size_t k = 0; k < place.count; ++k) {
    out[k] = static_cast<std::uint8_t>(std::min<std::uint16_t>(values[k], 255));
  }
}

void pack_instances(const InstanceOutput& output, const std::uint32_t* values, const Place& place) {
  const std::size_t pixel = place.view * place.pixels + place.first;
  std::memcpy(output.pixels.data() + pixel, values, 4 * place.count);
}

}  // namespace enfilade::render::cpu
