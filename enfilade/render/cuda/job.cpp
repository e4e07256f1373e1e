#include "enfilade/render/cuda/job.h"

#include <fmt/format.h>

#include "enfilade/render/cpu/pack.h"
#include "enfilade/render/cpu/row_plan.h"
#include "enfilade/render/detail/batch.h"
#include "enfilade/render/detail/layers.h"

namespace enfilade::render::cuda {
namespace {

using scan::Layer;

ColourKind kind_of(ColourFormat format) {
  constexpr std::array kKinds{kRgb, kBgr, kRgba, kPlanar16, kPlanar32};  // by ColourFormat
  return kKinds[static_cast<std::size_t>(format)];
}

DepthKind kind_of(DepthFormat format, bool legacy) {
  if (format == DepthFormat::kMetresFloat32) return legacy ? kLegacyMetres : kMetres;
  return legacy ? kLegacyUnits : kUnits;
}

}  // namespace

std::vector<std::string> Kinds::definitions() const {
  return {fmt::format("EN_COLOUR={}", static_cast<std::uint32_t>(colour)),
          fmt::format("EN_DEPTH={}", static_cast<std::uint32_t>(depth)),
          fmt::format("EN_CLASSES={}", static_cast<std::uint32_t>(classes)),
          fmt::format("EN_INSTANCES={}", instances ? 1 : 0),
          fmt::format("EN_CLAMPED={}", clamped ? 1 : 0)};
}

Kinds kinds_of(const Outputs& outputs, const Legacy& legacy) {
  Kinds kinds;
  if (outputs.colour) kinds.colour = kind_of(outputs.colour->format);
  kinds.clamped = outputs.colour && legacy.clamped_edges;
  if (outputs.depth) kinds.depth = kind_of(outputs.depth->format, legacy.eight_bit_depth);
  if (outputs.classes) {
    kinds.classes = outputs.classes->format == ClassFormat::kUint8 ? kClass8 : kClass16;
  }
  kinds.instances = outputs.instances.has_value();
  return kinds;
}

Kinds only(const Kinds& kinds, scan::Layer layer) {
  Kinds one;
  if (layer == Layer::kColour) {
    one.colour = kinds.colour;
    one.clamped = kinds.clamped;
  }
  if (layer == Layer::kDepth) one.depth = kinds.depth;
  if (layer == Layer::kClass) one.classes = kinds.classes;
  if (layer == Layer::kInstance) one.instances = kinds.instances;
  return one;
}

scan::LayerMask layers_of(const Kinds& kinds) {
  return static_cast<scan::LayerMask>(
      unsigned{kinds.colour != kNoColour} | unsigned{kinds.depth != kNoDepth} << 1U |
      unsigned{kinds.classes != kNoClasses} << 2U | unsigned{kinds.instances} << 3U);
}

Job make_job(const Camera& camera, const Kinds& kinds, const Outputs& outputs) {
  Job job{};
  job.width = camera.width;
  job.height = camera.height;
  job.bands = (camera.height + kBandRows - 1) / kBandRows;
  for (const Layer layer : detail::kEachLayer) {
    if (!detail::has(layers_of(kinds), layer)) continue;
    job.size_layer = static_cast<std::uint32_t>(index(layer));
    break;
  }
  const auto memory = [](std::span<std::byte> pixels) {
    return reinterpret_cast<u8*>(pixels.data());
  };
  if (kinds.colour != kNoColour) {
    job.colour = memory(outputs.colour->pixels);
    const cpu::PlanarScale scale = cpu::planar_scale(outputs.colour->normalisation);
    for (std::size_t c = 0; c < 3; ++c) {
      job.factor[c] = scale.factor[c];
      job.offset[c] = scale.offset[c];
    }
  }
  if (kinds.depth != kNoDepth) job.depth = memory(outputs.depth->pixels);
  if (kinds.classes != kNoClasses) job.classes = memory(outputs.classes->pixels);
  if (kinds.instances) job.instances = outputs.instances->pixels.data();
  return job;
}

Rays rays_of(const Camera& camera, const View& view, const scan::PanoramaSet& panoramas) {
  return cpu::plain(pixel_rays(camera, detail::panorama_from_camera(view, panoramas)));
}

}  // namespace enfilade::render::cuda
