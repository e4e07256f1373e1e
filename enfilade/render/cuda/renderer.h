/// \file  The CUDA back end.
#pragma once
#include <memory>

#include "enfilade/render/renderer.h"

namespace enfilade::render::cuda {

/// \throws ArgumentError if there is no card config.cuda_device
/// \throws Error naming the missing part, or with the message of CUDA or NVRTC
std::unique_ptr<Renderer> make_cuda_renderer(std::shared_ptr<FaceCache> faces,
                                             const RendererConfig& config);

}  // namespace enfilade::render::cuda
