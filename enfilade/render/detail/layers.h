/// \file  The back ends; and the layers of panoramas as tables and sets, for them and the face
/// cache.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "enfilade/core/errors.h"
#include "enfilade/render/face_cache.h"
#include "enfilade/render/renderer.h"

namespace enfilade::render::gl {
class GlContext;
}  // namespace enfilade::render::gl

namespace enfilade::render::detail {

/// All layers, by index(Layer).
inline constexpr std::array<scan::Layer, scan::kLayers> kEachLayer{
    scan::Layer::kColour, scan::Layer::kDepth, scan::Layer::kClass, scan::Layer::kInstance};

/// Bytes of a texel or pixel in memory, by index(Layer): RGBA, or the value as it is.
inline constexpr std::array<std::size_t, scan::kLayers> kTexelBytes{4, 2, 2, 4};

/// Texels around a face in memory.
constexpr std::uint32_t border_of(scan::Layer layer) {
  return layer == scan::Layer::kColour ? 1 : 0;
}

constexpr bool has(scan::LayerMask layers, scan::Layer layer) {
  return (layers >> index(layer) & 1U) != 0;
}

/// The layers that are to be drawn.
inline scan::LayerMask layers_of(const Outputs& outputs) noexcept {
  return static_cast<scan::LayerMask>(
      unsigned{outputs.colour.has_value()} | unsigned{outputs.depth.has_value()} << 1U |
      unsigned{outputs.classes.has_value()} << 2U | unsigned{outputs.instances.has_value()} << 3U);
}

/// \throws ArgumentError if a stream is requested, which only CUDA has
inline void refuse_stream(const Outputs& outputs) {
  if (outputs.stream) throw ArgumentError("outputs.stream: only the back end cuda has streams");
}

struct FaceKeyHash {
  std::size_t operator()(const FaceKey& key) const noexcept {
    const std::uint64_t place = std::uint64_t{key.scan.value} << 32 | key.viewpoint.value;
    const std::uint64_t all = place * 32 + index(key.layer) * 8 + index(key.face);
    return static_cast<std::size_t>(all * 0x9E3779B97F4A7C15U >> 20);  // 2^64 / golden ratio
  }
};

/// \pre config.backend is kCpu or kCpuScalar, faces is not null
std::unique_ptr<Renderer> make_cpu_renderer(std::shared_ptr<FaceCache> faces,
                                            const RendererConfig& config);

/// \throws ArgumentError if there is no card config.cuda_device
/// \throws Error naming the missing part, or with the message of CUDA or NVRTC
std::unique_ptr<Renderer> make_cuda_renderer(std::shared_ptr<FaceCache> faces,
                                             const RendererConfig& config);

/// A renderer with an OpenGL context of its own, current only while it draws. (EN_WITH_GL)
/// \throws ArgumentError if there is no device config.gl_device, with a list of devices
/// \throws Error with the message of EGL or OpenGL if no device, context or shader works
std::unique_ptr<Renderer> make_gl_renderer(std::shared_ptr<FaceCache> faces,
                                           const RendererConfig& config);
/// Likewise, with this context; config.gl_device does not matter.
std::unique_ptr<Renderer> make_gl_renderer(std::shared_ptr<FaceCache> faces,
                                           const RendererConfig& config,
                                           std::shared_ptr<gl::GlContext> context);

}  // namespace enfilade::render::detail
