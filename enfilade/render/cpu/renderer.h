/// \file  The CPU back ends.
#pragma once
#include <memory>

#include "enfilade/render/renderer.h"

namespace enfilade::render::cpu {

/// \pre config.backend is kCpu or kCpuScalar, faces is not null
std::unique_ptr<Renderer> make_cpu_renderer(std::shared_ptr<FaceCache> faces,
                                            const RendererConfig& config);

}  // namespace enfilade::render::cpu
