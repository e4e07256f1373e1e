#include "enfilade/render/pictures.h"

#include <span>

#include "enfilade/render/detail/layers.h"

namespace enfilade::render {

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
