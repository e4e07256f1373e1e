#include "enfilade/render/cpu/pack.h"

#include <algorithm>
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
void put(const BlockPlace& place, T* out, std::size_t count, const Pack& pack) {
  if (place.staging == nullptr) return pack(out);
  std::byte* room = place.staging->take(count * sizeof(T));
  pack(reinterpret_cast<T*>(room));
  place.staging->send(reinterpret_cast<std::byte*>(out), room, count * sizeof(T));
}

// A block's three planes.
template <class T, class Pack>
void put_planes(const BlockPlace& place, T* out, const Pack& pack) {
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

// The kernels of one way to make colours, by format.
template <class Three, class Rgba, class Planar16, class Planar32>
struct ColourKernels {
  Three rgb, bgr;
  Rgba rgba;
  Planar16 planar16;
  Planar32 planar32;
};
template <class Three, class... Others>
ColourKernels(Three, Three, Others...) -> ColourKernels<Three, Others...>;

// Has `call` run the output's kernel, with where it writes as the last arguments.
template <class Kernels, class Call>
void put_colour(const ColourOutput& output, const PlanarScale& scale, const BlockPlace& place,
                const Kernels& kernels, const Call& call) {
  const auto three = [&](const auto& kernel) {
    put(place, values_at<std::uint8_t>(output.pixels, 3 * place.pixel()), 3 * place.count,
        [&](std::uint8_t* out) { call(kernel, out); });
  };
  const auto planar = [&]<class T>(const auto& kernel, T* first) {
    put_planes(place, first + 3 * place.view * place.pixels + place.first,
               [&](T* out, std::size_t plane) { call(kernel, scale, plane, out); });
  };
  switch (output.format) {
    case ColourFormat::kRgb8:
      return three(kernels.rgb);
    case ColourFormat::kBgr8:
      return three(kernels.bgr);
    case ColourFormat::kRgba8:
      return put(place, values_at<std::uint32_t>(output.pixels, place.pixel()), place.count,
                 [&](std::uint32_t* out) { call(kernels.rgba, out); });
    case ColourFormat::kPlanarFloat16:
      return planar(kernels.planar16, values_at<std::uint16_t>(output.pixels, 0));
    case ColourFormat::kPlanarFloat32:
      return planar(kernels.planar32, values_at<float>(output.pixels, 0));
  }
}

// The same for depth.
template <class Metres, class Units, class Call>
void put_depth(const DepthOutput& output, const BlockPlace& place, Metres metres, Units units,
               const Call& call) {
  if (output.format == DepthFormat::kMetresFloat32) {
    put(place, values_at<float>(output.pixels, place.pixel()), place.count,
        [&](float* out) { call(metres, out); });
  } else {
    put(place, values_at<std::uint16_t>(output.pixels, place.pixel()), place.count,
        [&](std::uint16_t* out) { call(units, out); });
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

PixelPacker::PixelPacker(const PixelKernels& kernels, const Outputs& outputs,
                         bool eight_bit_depth) noexcept
    : kernels_(kernels), outputs_(outputs), eight_bit_depth_(eight_bit_depth) {
  if (outputs.colour) scale_ = planar_scale(outputs.colour->normalisation);
}

void PixelPacker::pack(const Values& values, const BlockPlace& place) const {
  if (outputs_.colour) pack_colour(values.rgba, place);
  if (outputs_.depth) pack_depth(values.depth, values.depth_factor, place);
  pack_ids(values, place);
}

void PixelPacker::pack_ids(const Values& values, const BlockPlace& place) const {
  if (outputs_.classes) pack_classes(values.classes, place);
  if (outputs_.instances) {
    std::memcpy(outputs_.instances->pixels.data() + place.pixel(), values.instances,
                4 * place.count);
  }
}

void PixelPacker::pack_colour(const std::uint32_t* rgba, const BlockPlace& place) const {
  const auto copy = [](const std::uint32_t* from, std::size_t count, std::uint32_t* out) {
    std::memcpy(out, from, 4 * count);
  };
  put_colour(*outputs_.colour, scale_, place,
             ColourKernels{kernels_.pack_rgb, kernels_.pack_bgr, copy, kernels_.pack_planar16,
                           kernels_.pack_planar32},
             [&](const auto& kernel, const auto&... to) { kernel(rgba, place.count, to...); });
}

void PixelPacker::draw_colour(const TapRun& run, const Ahead& ahead,
                              const BlockPlace& place) const {
  put_colour(*outputs_.colour, scale_, place,
             ColourKernels{kernels_.draw_rgb, kernels_.draw_bgr, kernels_.draw_rgba,
                           kernels_.draw_planar16, kernels_.draw_planar32},
             [&](const auto& kernel, const auto&... to) { kernel(run, ahead, to...); });
}

void PixelPacker::draw_depth(const PlaceRun& run, const float* factor,
                             const BlockPlace& place) const {
  if (eight_bit_depth_) {
    Block16 units;
    kernels_.values16(run, units.values.data());
    return pack_depth(units.values.data(), factor, place);
  }
  put_depth(*outputs_.depth, place, kernels_.draw_metres, kernels_.draw_units,
            [&](const auto& kernel, auto* out) { kernel(run, factor, out); });
}

void PixelPacker::pack_depth(const std::uint16_t* units, const float* factor,
                             const BlockPlace& place) const {
  put_depth(*outputs_.depth, place,
            eight_bit_depth_ ? kernels_.pack_legacy_metres : kernels_.pack_metres,
            eight_bit_depth_ ? kernels_.pack_legacy_units : kernels_.pack_units,
            [&](const auto& kernel, auto* out) { kernel(units, factor, place.count, out); });
}

void PixelPacker::pack_classes(const std::uint16_t* values, const BlockPlace& place) const {
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

std::vector<float> depth_factors(const Camera& camera, DepthMeasure measure) {
  std::vector<float> factors(std::size_t{camera.width} * camera.height, 1.0F);
  if (measure == DepthMeasure::kRay) return factors;
  const PixelRays rays = pixel_rays(camera, Mat3d{});
  for (std::uint32_t i = 0; i < camera.height; ++i) {
    for (std::uint32_t j = 0; j < camera.width; ++j) {
      factors[std::size_t{i} * camera.width + j] = static_cast<float>(1 / length(rays.at(i, j)));
    }
  }
  return factors;
}

}  // namespace enfilade::render::cpu
