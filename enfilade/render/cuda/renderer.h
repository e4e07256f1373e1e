/// \file  The CUDA back end.
#pragma once
#include <memory>

#include "enfilade/render/renderer.h"

namespace enfilade::render::cuda {

/// \throws ArgumentError if config.cuda_device names no card; Error that says what is missing, or
/// with CUDA's or NVRTC's words
std::unique_ptr<Renderer> make_cuda_renderer(std::shared_ptr<FaceCache> faces,
                                             const RendererConfig& config);

}  // namespace enfilade::render::cuda
