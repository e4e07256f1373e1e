/// \file  Many small pictures on one sheet, with captions.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "enfilade/image/image.h"

namespace enfilade::draw {

struct SheetPicture {
  image::Image8 picture;  ///< 3 channels
  std::string caption;    ///< ASCII; a line each; lines that are too long are cut off
};

struct SheetOptions {
  std::size_t columns = 0;  ///< 0: so many that the sheet is about as wide as 4 : 3
  std::string title;        ///< ASCII; above all, in as many lines as it takes; may be empty
};

/// The pictures in rows, from the top left, in cells of the size of the largest.
/// \throws ArgumentError if there is no picture, one is empty or not of 3 channels, or the sheet
/// would be larger than a picture may be (image::kLongestEdge, image::kMostPixels)
image::Image8 contact_sheet(std::span<const SheetPicture> pictures,
                            const SheetOptions& options = {});

}  // namespace enfilade::draw
