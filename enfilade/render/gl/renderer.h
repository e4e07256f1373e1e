/// \file  The OpenGL back end.
#pragma once
#include <memory>

#include "enfilade/render/gl/context.h"
#include "enfilade/render/renderer.h"

namespace enfilade::render::gl {

/// A renderer with an OpenGL context of its own, current only while it draws.
/// \throws ArgumentError if config.gl_device names no device, with a list of those there are; Error
/// with EGL's or OpenGL's words if no device, context or shader can be had
std::unique_ptr<Renderer> make_gl_renderer(std::shared_ptr<FaceCache> faces,
                                           const RendererConfig& config);
/// Likewise, with this context; config.gl_device does not matter.
std::unique_ptr<Renderer> make_gl_renderer(std::shared_ptr<FaceCache> faces,
                                           const RendererConfig& config,
                                           std::shared_ptr<Context> context);

}  // namespace enfilade::render::gl
