#include "enfilade/render/pack_pixels.h"

#include "enfilade/render/cpu/pack.h"

namespace enfilade::render {

void pack_colours(const ColourOutput& output, const PixelRun& run,
                  std::span<const std::uint32_t> rgba) {
  Outputs outputs;
  outputs.colour = output;
  const cpu::Packer packer(cpu::simd_kernels(), outputs, false);
  packer.pack({rgba.data(), nullptr, nullptr, nullptr, nullptr},
              {run.view, run.first, rgba.size(), run.view_pixels, nullptr});
}

}  // namespace enfilade::render
