/// \file  The OpenGL back end.
#pragma once
#include <memory>

#include "enfilade/render/gl/context.h"
#include "enfilade/render/renderer.h"

namespace enfilade::render::gl {

/// A renderer with an OpenGL context of its own, current only while it draws.
/// \throws ArgumentError if there is no device config.gl_device, with a list of devices
/// \throws Error with the message of EGL or OpenGL if no device, context or shader works
std::unique_ptr<Renderer> make_gl_renderer(std::shared_ptr<FaceCache> faces,
                                           const RendererConfig& config);
/// Likewise, with this context; config.gl_device does not matter.
std::unique_ptr<Renderer> make_gl_renderer(std::shared_ptr<FaceCache> faces,
                                           const RendererConfig& config,
                                           std::shared_ptr<Context> context);

}  // namespace enfilade::render::gl
