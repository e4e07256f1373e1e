/// \file  What a file says about its picture beside the pixels: EXIF and XMP. Internal. Notes that
/// cannot be read say nothing.
#pragma once
#include <string>

#include "enfilade/image/codecs.h"

namespace enfilade::image::detail {

struct PhotoNotes {
  int orientation = 1;  ///< EXIF's, 1 .. 8; 1 is upright
  std::string xmp;      ///< the packet, XML; empty: none
};

/// Sets the orientation from EXIF data, if they have a valid one. They begin with TIFF's header, or
/// with "Exif" and two zeros before it, as some writers of PNG and WebP have it too.
void read_exif(Bytes tiff, PhotoNotes& notes);
/// The notes of the segments APP1 before the scan.
PhotoNotes jpeg_notes(Bytes jpeg);
/// decode_png8(), with the notes of the chunks eXIf and iTXt, or zTXt and tEXt. Edges are halved
/// until there are at most `most` pixels, while the picture is read.
/// \throws InvalidInput, also if an interlaced one has more
Image8 decode_png8(Bytes png, const std::string& file, std::uint64_t most, PhotoNotes* notes);

}  // namespace enfilade::image::detail
