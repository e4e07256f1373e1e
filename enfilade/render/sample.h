/// \file  A picture with known pixels, to test renderers.
#pragma once
#include <memory>

#include "enfilade/render/face_cache.h"
#include "enfilade/render/renderer.h"

namespace enfilade::render {

/// One scan of one viewpoint, of one grey all around.
std::shared_ptr<FaceCache> sample_faces();

/// Draws them. \param renderer made with sample_faces() \throws Error if a pixel has another
/// colour; as Renderer::render()
void check_sample(Renderer& renderer);

}  // namespace enfilade::render
