/// \file  Conversion of blocks of pixels to the output formats; also used by the GL back end and
/// for equirectangular pictures.
#pragma once
#include <cstddef>
#include <cstdint>

#include "enfilade/render/cpu/kernels.h"
#include "enfilade/render/renderer.h"

namespace enfilade::render::cpu {

/// Where a block's pixels go: `first` is the place of its first pixel in its view, row-major.
struct Place {
  std::size_t view = 0;
  std::size_t first = 0;
  std::size_t count = 0;
  std::size_t pixels = 0;  ///< of a view
  bool stream = false;     ///< past the caches: the batch is larger than they are
};

PlanarScale planar_scale(const Normalisation& normalisation) noexcept;

void pack_colour(const Kernels& kernels, const ColourOutput& output, const PlanarScale& scale,
                 const std::uint32_t* rgba, const Place& place);
/// `factor[k]` turns the k-th pixel's ray length into what output.measure asks for.
void pack_depth(const Kernels& kernels, const DepthOutput& output, bool eight_bit,
                const std::uint16_t* units, const float* factor, const Place& place);
void pack_classes(const ClassOutput& output, const std::uint16_t* values, const Place& place);
void pack_instances(const InstanceOutput& output, const std::uint32_t* values, const Place& place);

}  // namespace enfilade::render::cpu
