/// \file  Colours in the formats of outputs, for renderers outside this library.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/render/renderer.h"

namespace enfilade::render {

/// A run of pixels of one view: `first` is the place of its first pixel in the view, row-major.
struct PixelRun {
  std::size_t view = 0;         ///< its place in the batch
  std::size_t first = 0;        ///< pixels
  std::size_t view_pixels = 0;  ///< width times height
};

/// Writes colours in the output's format, with the CPU back end's kernels. Allocates nothing.
/// \param rgba R in the lowest byte  \pre validate(outputs); the run lies in its view
void pack_colours(const ColourOutput& output, const PixelRun& run,
                  std::span<const std::uint32_t> rgba);

}  // namespace enfilade::render
