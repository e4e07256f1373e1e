/// \file  WebP pictures, by libwebp where it is built in. Internal.
#pragma once
#include <string>
#include <string_view>

#include "enfilade/image/codecs.h"

namespace enfilade::mesh::readers {

/// Whether this build has libwebp.
bool reads_webp() noexcept;
/// Whether the bytes begin as a WebP file does.
bool is_webp(std::string_view bytes);
/// Its size, without decoding it. \throws InvalidInput, also if the build has no libwebp
image::Shape webp_shape(std::string_view bytes, const std::string& file);
/// As RGB, or as RGBA if it has alpha. Edges are halved while the picture is read, until there
/// are at most `most` pixels.
/// \throws InvalidInput, also for an animation, and for a lossless picture of more pixels
image::Image8 decode_webp(std::string_view bytes, const std::string& file, std::uint64_t most);
/// The data of the chunk EXIF; empty: none.
std::string_view webp_exif(std::string_view bytes);

}  // namespace enfilade::mesh::readers
