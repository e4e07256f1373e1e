/// \file  Pictures that own the memory which a renderer draws into.
#pragma once
#include <cstddef>
#include <cstdint>

#include "enfilade/image/image.h"
#include "enfilade/render/renderer.h"
#include "enfilade/scan/panorama_source.h"

namespace enfilade::render {

/// n views, one above the other: shape (n height, width). Layers that are not drawn are empty.
struct Pictures {
  image::Image8 colour;      ///< RGB
  image::Image16 depth;      ///< quarter millimetres along the optical axis; 0: no reading
  image::Image16 classes;    ///< 0: none
  image::Image32 instances;  ///< 0: none
};

/// Makes room in `pictures` for `views` views of the layers in `layers`. Other layers do not
/// change.
/// \returns outputs for Renderer::render(), valid as long as `pictures` is not changed
Outputs outputs_into(Pictures& pictures, scan::LayerMask layers, std::uint32_t width,
                     std::uint32_t height, std::size_t views = 1);

}  // namespace enfilade::render
