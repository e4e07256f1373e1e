#include "enfilade/render/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/render/cpu/pack.h"
#include "enfilade/render/detail/layers.h"

namespace enfilade::render {
namespace {

void validate_size(std::string_view name, std::size_t bytes, std::size_t pixels,
                   std::size_t pixel_bytes) {
  if (bytes == pixels * pixel_bytes) return;
  throw ArgumentError(fmt::format("outputs.{}: {} bytes, but {} pixels of {} bytes take {}", name,
                                  bytes, pixels, pixel_bytes, pixels * pixel_bytes));
}

void validate_alignment(std::string_view name, const void* memory, std::size_t alignment) {
  if (reinterpret_cast<std::uintptr_t>(memory) % alignment == 0) return;
  throw ArgumentError(
      fmt::format("outputs.{}: its values need addresses divisible by {}", name, alignment));
}

void validate(const ColourOutput& colour, std::size_t pixels) {
  validate_size("colour", colour.pixels.size(), pixels, pixel_bytes(colour.format));
  validate_alignment("colour", colour.pixels.data(),
                     colour.format == ColourFormat::kPlanarFloat32   ? alignof(float)
                     : colour.format == ColourFormat::kPlanarFloat16 ? alignof(std::uint16_t)
                                                                     : 1);
  for (std::size_t c = 0; c < 3; ++c) {
    const float mean = colour.normalisation.mean[c], deviation = colour.normalisation.deviation[c];
    if (!std::isfinite(mean)) {
      throw ArgumentError(
          fmt::format("outputs.colour.normalisation.mean[{}]: {}, not finite", c, mean));
    }
    if (!(deviation > 0) || !std::isfinite(deviation)) {
      throw ArgumentError(
          fmt::format("outputs.colour.normalisation.deviation[{}]: {}, not above 0", c, deviation));
    }
  }
}

void validate(const View& view, std::size_t place, const scan::PanoramaSet& panoramas) {
  const auto fail = [&](const std::string& what) {
    throw ArgumentError(fmt::format("views[{}].{}", place, what));
  };
  if (view.scan.at() >= panoramas.size()) {
    fail(fmt::format("scan: {}, but there are {} scans", view.scan.value, panoramas.size()));
  }
  const scan::PanoramaSource& source = panoramas.source(view.scan);
  if (view.viewpoint.at() >= source.size()) {
    fail(fmt::format("viewpoint: {}, but scan {} has {} viewpoints", view.viewpoint.value,
                     source.scan(), source.size()));
  }
  if (!std::isfinite(view.heading.value)) {
    fail(fmt::format("heading: {}, not finite", view.heading.value));
  }
  if (!(std::abs(view.elevation.value) <= kPi / 2)) {
    fail(fmt::format("elevation: {}, not in [-pi/2, pi/2]", view.elevation.value));
  }
}

}  // namespace

std::size_t pixel_bytes(ColourFormat format) noexcept {
  constexpr std::array<std::size_t, 5> kBytes{3, 3, 4, 6, 12};  // by ColourFormat
  return kBytes[static_cast<std::size_t>(format)];
}

std::size_t pixel_bytes(DepthFormat format) noexcept {
  return format == DepthFormat::kMetresFloat32 ? 4 : 2;
}

std::size_t pixel_bytes(ClassFormat format) noexcept {
  return format == ClassFormat::kUint8 ? 1 : 2;
}

std::vector<Backend> backends() {
  std::vector<Backend> all{Backend::kCpu, Backend::kCpuScalar};
  if (EN_WITH_GL) all.push_back(Backend::kGl);
  all.push_back(Backend::kCuda);
  return all;
}

std::array<View, kDiscreteViews> discrete_views(ScanIndex scan, ViewpointIndex viewpoint) {
  constexpr std::size_t kHeadings = 12;
  std::array<View, kDiscreteViews> views;
  for (std::size_t k = 0; k < views.size(); ++k) {
    // MatterSim's own arithmetic, so that a view is drawn at exactly the heading in its state.
    const double heading = static_cast<double>(k % kHeadings) * (2 * kPi / 12);
    const double elevation = (static_cast<double>(k / kHeadings) - 1) * (kPi / 6);
    views[k] = {scan, viewpoint, Radians(heading), Radians(elevation)};
  }
  return views;
}

void validate(const Outputs& outputs, std::size_t pixels) {
  const auto validate_values = [&](std::string_view name, const auto& output) {
    const std::size_t bytes = pixel_bytes(output.format);
    validate_size(name, output.pixels.size(), pixels, bytes);
    validate_alignment(name, output.pixels.data(), bytes);
  };
  if (outputs.colour) validate(*outputs.colour, pixels);
  if (outputs.depth) validate_values("depth", *outputs.depth);
  if (outputs.classes) validate_values("classes", *outputs.classes);
  if (outputs.instances) {
    validate_size("instances", outputs.instances->pixels.size_bytes(), pixels,
                  sizeof(std::uint32_t));
  }
}

void validate(const Camera& camera, std::span<const View> views, const Outputs& outputs,
              const scan::PanoramaSet& panoramas) {
  validate(camera);
  const std::size_t pixels = views.size() * camera.width * camera.height;
  validate(outputs, pixels);
  for (std::size_t k = 0; k < views.size(); ++k) validate(views[k], k, panoramas);
}

std::unique_ptr<Renderer> make_renderer(std::shared_ptr<FaceCache> faces,
                                        const RendererConfig& config) {
  if (!faces) throw ArgumentError("faces: null, but a renderer needs a FaceCache");
  if (config.threads < 0) {
    throw ArgumentError(fmt::format("config.threads: {}, below 0", config.threads));
  }
  if (config.backend == Backend::kCuda) return detail::make_cuda_renderer(std::move(faces), config);
  if (config.backend != Backend::kGl) return detail::make_cpu_renderer(std::move(faces), config);
#if EN_WITH_GL
  return detail::make_gl_renderer(std::move(faces), config);
#else
  throw ArgumentError("config.backend: gl, but this build has no OpenGL (EN_WITH_GL was OFF)");
#endif
}

void pack_colours(const ColourOutput& output, const PixelRun& run,
                  std::span<const std::uint32_t> rgba) {
  Outputs outputs;
  outputs.colour = output;
  const cpu::PixelPacker packer(cpu::simd_kernels(), outputs, false);
  packer.pack({rgba.data(), nullptr, nullptr, nullptr, nullptr},
              {run.view, run.first, rgba.size(), run.view_pixels, nullptr});
}

Outputs outputs_into(Pictures& pictures, scan::LayerMask layers, std::uint32_t width,
                     std::uint32_t height, std::size_t views) {
  const auto rows = static_cast<std::uint32_t>(height * views);
  const auto wanted = [&](scan::Layer layer) { return detail::has(layers, layer); };
  Outputs outputs;
  if (wanted(scan::Layer::kColour)) {
    pictures.colour = image::Image8(width, rows, 3);
    outputs.colour.emplace().pixels = std::as_writable_bytes(std::span(pictures.colour.pixels));
  }
  if (wanted(scan::Layer::kDepth)) {
    pictures.depth = image::Image16(width, rows, 1);
    outputs.depth.emplace().format = DepthFormat::kQuarterMillimetresUint16;
    outputs.depth->pixels = std::as_writable_bytes(std::span(pictures.depth.pixels));
  }
  if (wanted(scan::Layer::kClass)) {
    pictures.classes = image::Image16(width, rows, 1);
    outputs.classes.emplace().pixels = std::as_writable_bytes(std::span(pictures.classes.pixels));
  }
  if (wanted(scan::Layer::kInstance)) {
    pictures.instances = image::Image32(width, rows, 1);
    outputs.instances.emplace().pixels = pictures.instances.pixels;
  }
  return outputs;
}

}  // namespace enfilade::render
