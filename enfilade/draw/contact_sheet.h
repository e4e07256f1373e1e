/// \file  Contact sheets: many small pictures with captions.
#pragma once
#include <cstddef>
#include <span>
#include <string>

#include "enfilade/image/image.h"

namespace enfilade::draw {

/// One cell of a contact sheet.
struct SheetPicture {
  image::Image8 picture;  ///< 3 channels
  std::string caption;    ///< ASCII; may have several lines; lines that are too long are cut
};

/// How a contact sheet is laid out.
struct SheetOptions {
  std::size_t columns = 0;  ///< 0: chosen so that the sheet is about 4 : 3
  std::string title;        ///< ASCII; at the top, wrapped; may be empty
};

/// Arranges the pictures in rows, from the top left, in cells of the size of the largest.
/// \throws ArgumentError if there is no picture, one is empty or not of 3 channels, or the sheet
/// would be larger than a picture may be (image::kLongestEdge, image::kMostPixels)
image::Image8 contact_sheet(std::span<const SheetPicture> pictures,
                            const SheetOptions& options = {});

}  // namespace enfilade::draw
