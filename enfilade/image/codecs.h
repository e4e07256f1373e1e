/// \file  JPEG, PNG and Radiance HDR, in memory. Every reader refuses what it cannot read whole: a
/// truncated or damaged file is InvalidInput naming `file` (the name to use in messages), what was
/// found and what was allowed. All functions may be called from any thread.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/image/image.h"

namespace enfilade::image {

using Bytes = std::span<const std::uint8_t>;
inline Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The longest edge that a reader accepts, in pixels: above any panorama, below what would let a
/// damaged header ask for all memory.
inline constexpr std::uint32_t kLongestEdge = 65500;
/// And the most pixels.
inline constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 29;

struct Shape {
  std::uint32_t width = 0, height = 0, channels = 0;
  std::uint32_t bits = 8;  ///< a channel
  friend bool operator==(const Shape&, const Shape&) = default;
};

// --- JPEG -----------------------------------------------------------------------------------
// Damage of any kind that libjpeg-turbo notices is refused, also what many programs pass over: a
// missing end marker, bytes that belong to nothing. A wrong bit need not be noticed: JPEG has no
// checksums.

/// Reads the header only. \throws InvalidInput
Shape jpeg_shape(Bytes jpeg, const std::string& file);
/// RGB; greyscale comes out as three equal channels. \throws InvalidInput, also for CMYK
Image8 decode_jpeg(Bytes jpeg, const std::string& file);
/// Into memory of the caller as RGBA with A = 255: `rows` points to the first of `shape.height`
/// rows, `stride` bytes apart. After a thread's first call, takes no memory but what libjpeg-turbo
/// does for its time.
/// \throws InvalidInput; ArgumentError if the picture is not width x height
void decode_jpeg_rgba(Bytes jpeg, std::uint32_t width, std::uint32_t height, std::uint8_t* rows,
                      std::size_t stride, const std::string& file);
/// \param picture 1 or 3 channels  \param quality 1 .. 100  \param full_chroma 4:4:4, else 4:2:0
std::vector<std::uint8_t> encode_jpeg(const Image8& picture, int quality, bool full_chroma = false);
/// The six faces of a strip as six baseline JPEGs with the very coefficients of the strip: nothing
/// is decoded. Nothing if its blocks don't end at the faces' edges or it is no strip. Where chroma
/// is halved, the columns next to a cut decode otherwise than in the strip, whose decoder smooths
/// chroma from one face into the next.
/// \throws InvalidInput
std::optional<std::array<std::vector<std::uint8_t>, kCubeFaces>> cut_jpeg_strip(
    Bytes jpeg, const std::string& file);

// --- PNG ------------------------------------------------------------------------------------

Shape png_shape(Bytes png, const std::string& file);
/// 8-bit (or less: scaled up); palette comes out as RGB or RGBA. A transparent colour of a grey or
/// RGB file is not looked at. \throws InvalidInput, also for 16
Image8 decode_png8(Bytes png, const std::string& file);
/// Greyscale of up to 16 bits, one channel, values as stored. \throws InvalidInput, also for colour
Image16 decode_png16(Bytes png, const std::string& file);
/// \param picture 1, 2 (grey, alpha), 3 or 4 channels
std::vector<std::uint8_t> encode_png(const Image8& picture);
/// Greyscale. \param picture 1 channel
std::vector<std::uint8_t> encode_png(const Image16& picture);

/// Ids of 32 bits as a PNG: 16-bit greyscale if none is above 65535, else 8-bit RGBA with
/// id = R + 256 G + 65536 B + 2^24 A. \param ids 1 channel
std::vector<std::uint8_t> encode_ids(const Image32& ids);
/// Its inverse; any greyscale is read. \throws InvalidInput, also for other PNGs
Image32 decode_ids(Bytes png, const std::string& file);

// --- Radiance HDR (RGBE) --------------------------------------------------------------------

/// Linear light, RGB, the file's exposure taken back. Run-length coded (new and old style) and flat
/// files with `-Y h +X w`, and the other seven orientations; at most 2^27 pixels. Source: the
/// format as Radiance's `color.c` defines it. \throws InvalidInput, also for XYZE
ImageF decode_hdr(Bytes hdr, const std::string& file);
/// For people's eyes: exposure so that the median luminance becomes mid-grey (18 %) unless one is
/// given (stops: 0 leaves values as they are), a filmic shoulder, sRGB.
/// \throws ArgumentError unless there are 3 channels
Image8 tone_map(const ImageF& linear, std::optional<double> exposure = std::nullopt);

// --- by content -----------------------------------------------------------------------------

/// JPEG, 8-bit PNG or HDR (tone-mapped with that exposure), told by the first bytes; 3 channels.
/// \throws FileError; InvalidInput
Image8 load_picture(const std::string& path, std::optional<double> exposure = std::nullopt);

/// Writes a picture of 1 or 3 channels as the name says: .png, .jpg or .jpeg. Atomic.
/// \param jpeg_quality 1 .. 100, 4:4:4 from 90 on; not looked at for PNG
/// \throws FileError; ArgumentError for another name
void save(const std::string& path, const Image8& picture, int jpeg_quality = 92);

}  // namespace enfilade::image
