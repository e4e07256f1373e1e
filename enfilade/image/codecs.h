/// \file  Codecs: JPEG, PNG and Radiance HDR, in memory. A truncated or damaged file is never read
/// in part. Readers throw InvalidInput naming `file` (its name for messages), the value found and
/// the values allowed. All functions may be called from any thread.
#pragma once
#include <array>
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

/// The content of a file in memory.
using Bytes = std::span<const std::uint8_t>;
inline Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The longest edge that a reader accepts, in pixels. Larger than any panorama's. With kMostPixels
/// it keeps a reader from allocating all memory for a damaged header.
inline constexpr std::uint32_t kLongestEdge = 65500;
/// The largest number of pixels that a reader accepts.
inline constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 29;

/// Pixels of an edge after `halvings` halvings, rounded up.
constexpr std::uint32_t halved(std::uint32_t edge, unsigned halvings) {
  return static_cast<std::uint32_t>(((std::uint64_t{edge} - 1) >> halvings) + 1);
}
/// How often both edges have to be halved until there are at most `most` pixels. \pre most > 0
constexpr unsigned halvings_to(std::uint32_t width, std::uint32_t height, std::uint64_t most) {
  unsigned times = 0;
  while (std::uint64_t{halved(width, times)} * halved(height, times) > most) ++times;
  return times;
}
/// For readers that reduce large pictures. \param kind  of this one, that is decoded whole alone
/// \throws InvalidInput
[[noreturn]] void refuse_whole(const char* kind, std::uint32_t width, std::uint32_t height,
                               std::uint64_t most, const std::string& file);

/// Size and channels of a picture, as its file's header says.
struct Shape {
  std::uint32_t width = 0, height = 0, channels = 0;
  std::uint32_t bits = 8;  ///< per channel
  friend bool operator==(const Shape&, const Shape&) = default;
};

// --- JPEG -----------------------------------------------------------------------------------
// All damage that libjpeg-turbo reports is an error, also what many programs ignore: a missing end
// marker, a bad code. Extraneous bytes before a marker and odd numbers in a scan's header are
// harmless. A flipped bit may go unnoticed, as JPEG has no checksums. EXIF's orientation is not
// applied: decode_photo() (photo.h) does so.

/// Reads the header only. Channels: 1 for greyscale, else 3. \throws InvalidInput
Shape jpeg_shape(Bytes jpeg, const std::string& file);
/// RGB; greyscale becomes three equal channels; CMYK and YCCK are converted without a profile.
/// \param findings  takes a warning `odd-jpeg` with a count of harmless oddities, and a note
/// `printing-colours` on CMYK  \throws InvalidInput
Image8 decode_jpeg(Bytes jpeg, const std::string& file,
                   std::vector<Diagnostic>* findings = nullptr);
/// The same, into the caller's 3 x width x height bytes. After a thread's first call only
/// libjpeg-turbo allocates. \throws InvalidInput; ArgumentError if the picture is not width x
/// height
void decode_jpeg(Bytes jpeg, std::uint32_t width, std::uint32_t height, std::span<std::uint8_t> rgb,
                 const std::string& file);
/// From this quality on, writers keep chroma at full resolution (4:4:4). Below it, halving the
/// resolution (4:2:0) is not visible.
inline constexpr int kFullChromaQuality = 90;
/// \param picture 1 or 3 channels  \param quality 1 .. 100  \param full_chroma 4:4:4, else 4:2:0
/// \throws ArgumentError for other channels or qualities, and edges above kLongestEdge
std::vector<std::uint8_t> encode_jpeg(const Image8& picture, int quality, bool full_chroma = false);
/// The six faces of a strip as baseline JPEGs with the coefficients of the strip, without decoding.
/// No value if it is not a strip, is CMYK, or its blocks do not end at the edges of faces. With
/// subsampled chroma, columns next to a cut do not decode to the same values as in the strip. There
/// the decoder interpolates chroma across faces. \throws InvalidInput
std::optional<std::array<std::vector<std::uint8_t>, kCubeFaces>> cut_jpeg_strip(
    Bytes jpeg, const std::string& file);

// --- PNG ------------------------------------------------------------------------------------

/// Reads the header only. \throws InvalidInput
Shape png_shape(Bytes png, const std::string& file);
/// 8 bits per channel: fewer bits are scaled up, 16 are rounded. A palette becomes RGB or RGBA. The
/// transparent colour of a grey or RGB file is ignored. \throws InvalidInput
Image8 decode_png8(Bytes png, const std::string& file);
/// Greyscale of up to 16 bits, one channel, values as stored. \throws InvalidInput, also for colour
Image16 decode_png16(Bytes png, const std::string& file);
/// \param picture 1, 2 (grey, alpha), 3 or 4 channels
std::vector<std::uint8_t> encode_png(const Image8& picture);
/// Greyscale of 16 bits. \pre picture.channels == 1
std::vector<std::uint8_t> encode_png(const Image16& picture);

/// Ids of 32 bits as a PNG: 16-bit greyscale if none is above 65535, else 8-bit RGBA with
/// id = R + 256 G + 65536 B + 2^24 A. \param ids 1 channel
std::vector<std::uint8_t> encode_ids(const Image32& ids);
/// The inverse of encode_ids(). Greyscale of any bits is read too. \throws InvalidInput, also for
/// other PNGs
Image32 decode_ids(Bytes png, const std::string& file);

// --- Radiance HDR (RGBE) --------------------------------------------------------------------

/// Linear light, RGB, divided by the file's exposure. Reads uncompressed files and both run-length
/// codings, in all eight orientations (`-Y h +X w`, ...); at most 2^27 pixels. Source: Radiance's
/// `color.c`, which defines the format.
/// \param most  pixels; edges of a larger picture are halved while it is read, by averages
/// \param stored  takes the file's size  \throws InvalidInput, also for XYZE
ImageF decode_hdr(Bytes hdr, const std::string& file, std::uint64_t most = kMostPixels,
                  Shape* stored = nullptr);
/// Linear light to sRGB: exposure (in stops, 0 leaves values as they are; default: the median
/// luminance becomes mid-grey, 18 %), then the tone curve of tone.h.
/// \throws ArgumentError unless there are 3 channels
Image8 tone_map(const ImageF& linear, std::optional<double> exposure = std::nullopt);

// --- files ----------------------------------------------------------------------------------

/// Writes a picture of 1 or 3 channels as the name says: .png, .jpg or .jpeg. Atomic.
/// \param jpeg_quality 1 .. 100, 4:4:4 from kFullChromaQuality on; ignored for PNG
/// \throws FileError; ArgumentError for another name
void save(const std::string& path, const Image8& picture, int jpeg_quality = 92);

}  // namespace enfilade::image
