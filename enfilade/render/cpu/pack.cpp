#include "enfilade/render/cpu/pack.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "enfilade/core/check.h"

namespace enfilade::render::cpu {
namespace {

template <class T>
T* values_at(std::span<std::byte> pixels, std::size_t first) {
  return reinterpret_cast<T*>(pixels.data()) + first;
}

// Lets `pack` write a block's values to `out`, straight or by way of the staging.
template <class T, class Pack>
void put(const Place& place, T* out, std::size_t count, const Pack& pack) {
  if (place.staging == nullptr) return pack(out);
  std::byte* room = place.staging->take(count * sizeof(T));
  pack(reinterpret_cast<T*>(room));
  place.staging->send(reinterpret_cast<std::byte*>(out), room, count * sizeof(T));
}

// A block's three planes.
template <class T, class Pack>
void put_planes(const Place& place, T* out, const Pack& pack) {
  if (place.staging == nullptr) return pack(out, place.pixels);
  constexpr std::size_t kLine = 64 / sizeof(T);
  const std::size_t plane = (place.count + kLine - 1) / kLine * kLine;
  std::byte* room = place.staging->take(3 * plane * sizeof(T));
  pack(reinterpret_cast<T*>(room), plane);
  for (std::size_t c = 0; c < 3; ++c) {
    place.staging->send(reinterpret_cast<std::byte*>(out + c * place.pixels),
                        room + c * plane * sizeof(T), place.count * sizeof(T));
  }
}

}  // namespace

std::byte* Staging::take(std::size_t bytes) {
  std::byte* room = memory_.data() + used_;
  used_ += (bytes + kLine - 1) / kLine * kLine;
  EN_CHECK_LE(used_, memory_.size());
  return room;
}

void Staging::send(std::byte* to, const std::byte* from, std::size_t bytes) {
  EN_CHECK_LT(count_, copies_.size());
  copies_[count_++] = {to, from, bytes};
}

void Staging::flush() {
  for (std::size_t k = 0; k < count_; ++k) {
    kernels_.stream(copies_[k].to, copies_[k].from, copies_[k].bytes);
  }
  used_ = count_ = 0;
}

Packer::Packer(const Kernels& kernels, const Outputs& outputs, bool eight_bit_depth) noexcept
    : kernels_(kernels), outputs_(outputs), eight_bit_depth_(eight_bit_depth) {
  if (outputs.colour) scale_ = planar_scale(outputs.colour->normalisation);
}

void Packer::pack(const Values& values, const Place& place) const {
  if (outputs_.colour) pack_colour(values.rgba, place);
  if (outputs_.depth) pack_depth(values.depth, values.depth_factor, place);
  pack_ids(values, place);
}

void Packer::pack_ids(const Values& values, const Place& place) const {
  if (outputs_.classes) pack_classes(values.classes, place);
  if (outputs_.instances) {
    std::memcpy(outputs_.instances->pixels.data() + place.pixel(), values.instances,
                4 * place.count);
  }
}

template <class From>
void Packer::put_colour(const From& from, const Place& place) const {
  const std::span<std::byte> pixels = outputs_.colour->pixels;
  const auto three = [&](const auto& write) {
    put(place, values_at<std::uint8_t>(pixels, 3 * place.pixel()), 3 * place.count, write);
  };
  const auto planar = [&]<class T>(const auto& write, T* first) {
    put_planes(place, first + 3 * place.view * place.pixels + place.first, write);
  };
  switch (outputs_.colour->format) {
    case ColourFormat::kRgb8:
      return three([&](std::uint8_t* out) { from.rgb(out); });
    case ColourFormat::kBgr8:
      return three([&](std::uint8_t* out) { from.bgr(out); });
    case ColourFormat::kRgba8:
      return put(place, values_at<std::uint32_t>(pixels, place.pixel()), place.count,
                 [&](std::uint32_t* out) { from.rgba(out); });
    case ColourFormat::kPlanarFloat16:
      return planar([&](std::uint16_t* out, std::size_t plane) { from.planar16(plane, out); },
                    values_at<std::uint16_t>(pixels, 0));
    case ColourFormat::kPlanarFloat32:
      return planar([&](float* out, std::size_t plane) { from.planar32(plane, out); },
                    values_at<float>(pixels, 0));
  }
}

void Packer::pack_colour(const std::uint32_t* rgba, const Place& place) const {
  struct Pixels {
    const Kernels& kernels;
    const PlanarScale& scale;
    const std::uint32_t* pixels;
    std::size_t count;
    void rgb(std::uint8_t* out) const { kernels.pack_rgb(pixels, count, out); }
    void bgr(std::uint8_t* out) const { kernels.pack_bgr(pixels, count, out); }
    void rgba(std::uint32_t* out) const { std::memcpy(out, pixels, 4 * count); }
    void planar16(std::size_t plane, std::uint16_t* out) const {
      kernels.pack_planar16(pixels, count, scale, plane, out);
    }
    void planar32(std::size_t plane, float* out) const {
      kernels.pack_planar32(pixels, count, scale, plane, out);
    }
  };
  put_colour(Pixels{kernels_, scale_, rgba, place.count}, place);
}

void Packer::draw_colour(const TapRun& taps, const Ahead& ahead, const Place& place) const {
  struct Drawn {
    const Kernels& kernels;
    const PlanarScale& scale;
    const TapRun& run;
    const Ahead& ahead;
    void rgb(std::uint8_t* out) const { kernels.draw_rgb(run, ahead, out); }
    void bgr(std::uint8_t* out) const { kernels.draw_bgr(run, ahead, out); }
    void rgba(std::uint32_t* out) const { kernels.draw_rgba(run, ahead, out); }
    void planar16(std::size_t plane, std::uint16_t* out) const {
      kernels.draw_planar16(run, ahead, scale, plane, out);
    }
    void planar32(std::size_t plane, float* out) const {
      kernels.draw_planar32(run, ahead, scale, plane, out);
    }
  };
  put_colour(Drawn{kernels_, scale_, taps, ahead}, place);
}

template <class From>
void Packer::put_depth(const From& from, const Place& place) const {
  const std::span<std::byte> pixels = outputs_.depth->pixels;
  if (outputs_.depth->format == DepthFormat::kMetresFloat32) {
    put(place, values_at<float>(pixels, place.pixel()), place.count,
        [&](float* out) { from.metres(out); });
  } else {
    put(place, values_at<std::uint16_t>(pixels, place.pixel()), place.count,
        [&](std::uint16_t* out) { from.units(out); });
  }
}

void Packer::draw_depth(const PlaceRun& run, const float* factor, const Place& place) const {
  if (eight_bit_depth_) {
    Block16 units;
    kernels_.values16(run, units.values.data());
    return pack_depth(units.values.data(), factor, place);
  }
  struct Drawn {
    const Kernels& kernels;
    const PlaceRun& run;
    const float* factor;
    void metres(float* out) const { kernels.draw_metres(run, factor, out); }
    void units(std::uint16_t* out) const { kernels.draw_units(run, factor, out); }
  };
  put_depth(Drawn{kernels_, run, factor}, place);
}

void Packer::pack_depth(const std::uint16_t* units, const float* factor, const Place& place) const {
  struct Packed {
    const Packer& packer;
    const std::uint16_t* values;
    const float* factor;
    std::size_t count;
    void metres(float* out) const {
      const Kernels& k = packer.kernels_;
      const auto kernel = packer.eight_bit_depth_ ? k.pack_legacy_metres : k.pack_metres;
      kernel(values, factor, count, out);
    }
    void units(std::uint16_t* out) const {
      const Kernels& k = packer.kernels_;
      const auto kernel = packer.eight_bit_depth_ ? k.pack_legacy_units : k.pack_units;
      kernel(values, factor, count, out);
    }
  };
  put_depth(Packed{*this, units, factor, place.count}, place);
}

void Packer::pack_classes(const std::uint16_t* values, const Place& place) const {
  const std::span<std::byte> pixels = outputs_.classes->pixels;
  if (outputs_.classes->format == ClassFormat::kUint16) {
    std::memcpy(pixels.data() + 2 * place.pixel(), values, 2 * place.count);
    return;
  }
  auto* out = values_at<std::uint8_t>(pixels, place.pixel());
  for (std::size_t k = 0; k < place.count; ++k) {
    out[k] = static_cast<std::uint8_t>(std::min<std::uint16_t>(values[k], 255));
  }
}

PlanarScale planar_scale(const Normalisation& normalisation) noexcept {
  PlanarScale scale{};
  for (std::size_t c = 0; c < 3; ++c) {
    scale.factor[c] = 1.0F / (255.0F * normalisation.deviation[c]);
    scale.offset[c] = -normalisation.mean[c] / normalisation.deviation[c];
  }
  return scale;
}

std::vector<float> inverse_ray_lengths(const Camera& camera) {
  const PixelRays rays = pixel_rays(camera, Mat3d{});
  std::vector<float> lengths(std::size_t{camera.width} * camera.height);
  for (std::uint32_t i = 0; i < camera.height; ++i) {
    for (std::uint32_t j = 0; j < camera.width; ++j) {
      lengths[std::size_t{i} * camera.width + j] = static_cast<float>(1 / length(rays.at(i, j)));
    }
  }
  return lengths;
}

}  // namespace enfilade::render::cpu
