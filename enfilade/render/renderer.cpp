#include "enfilade/render/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/render/cpu/renderer.h"
#include "enfilade/render/cuda/renderer.h"
#if EN_WITH_GL
#include "enfilade/render/gl/renderer.h"
#endif

namespace enfilade::render {
namespace {

constexpr std::array<std::string_view, 4> kBackends{"cpu", "cpu-scalar", "gl",
                                                    "cuda"};  // by Backend

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
  switch (format) {
    case ColourFormat::kRgb8:
    case ColourFormat::kBgr8:
      return 3;
    case ColourFormat::kRgba8:
      return 4;
    case ColourFormat::kPlanarFloat16:
      return 6;
    case ColourFormat::kPlanarFloat32:
      return 12;
  }
  return 0;
}

std::size_t pixel_bytes(DepthFormat format) noexcept {
  return format == DepthFormat::kMetresFloat32 ? 4 : 2;
}

std::size_t pixel_bytes(ClassFormat format) noexcept {
  return format == ClassFormat::kUint8 ? 1 : 2;
}

std::string_view to_string(Backend backend) { return kBackends[static_cast<std::size_t>(backend)]; }

std::optional<Backend> parse_backend(std::string_view name) {
  const auto found = std::ranges::find(kBackends, name);
  if (found == kBackends.end()) return std::nullopt;
  return static_cast<Backend>(found - kBackends.begin());
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
  if (config.backend == Backend::kCuda) return cuda::make_cuda_renderer(std::move(faces), config);
  if (config.backend != Backend::kGl) return cpu::make_cpu_renderer(std::move(faces), config);
#if EN_WITH_GL
  return gl::make_gl_renderer(std::move(faces), config);
#else
  throw ArgumentError("config.backend: gl, but this build has no OpenGL (EN_WITH_GL was OFF)");
#endif
}

}  // namespace enfilade::render
