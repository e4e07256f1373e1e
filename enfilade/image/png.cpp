#include <fmt/format.h>
#include <spng.h>
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/detail/check_size.h"
#include "enfilade/image/detail/photo_notes.h"
#include "enfilade/image/detail/row_shrinker.h"

namespace enfilade::image {

using namespace detail;

namespace {

struct FreeContext {
  void operator()(spng_ctx* context) const noexcept { spng_ctx_free(context); }
};
using Context = std::unique_ptr<spng_ctx, FreeContext>;
struct FreeBytes {
  void operator()(void* bytes) const noexcept { std::free(bytes); }
};

// Limit of a chunk without pixels: a colour profile, a text, a thumbnail.
constexpr std::size_t kLargestChunk = std::size_t{64} << 20;

void check_png(int result, const std::string& file) {
  if (result == SPNG_OK) return;
  const bool cut = result == SPNG_IO_EOF || result == SPNG_EOF || result == SPNG_EIDAT_TOO_SHORT;
  refuse(file, "", cut ? "truncated-png" : "bad-png",
         fmt::format("{}: {}", cut ? "the PNG ends too early" : "no PNG that can be read",
                     spng_strerror(result)));
}

unsigned channels_of(std::uint8_t colour_type) {
  switch (colour_type) {
    case SPNG_COLOR_TYPE_GRAYSCALE:
    case SPNG_COLOR_TYPE_INDEXED:
      return 1;
    case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA:
      return 2;
    case SPNG_COLOR_TYPE_TRUECOLOR:
      return 3;
    default:
      return 4;
  }
}

class Reader {
 public:
  Reader(Bytes png, const std::string& file) : file_(file), context_(spng_ctx_new(0)) {
    EN_CHECK(context_ != nullptr);
    spng_set_crc_action(context_.get(), SPNG_CRC_ERROR, SPNG_CRC_ERROR);
    spng_set_image_limits(context_.get(), kLongestEdge, kLongestEdge);
    spng_set_chunk_limits(context_.get(), kLargestChunk, kLargestChunk);
    check_png(spng_set_png_buffer(context_.get(), png.data(), png.size()), file_);
    check_png(spng_get_ihdr(context_.get(), &header_), file_);
    check_size(header_.width, header_.height, file_);
    // Deflate cannot shrink by more than 1032 : 1 (RFC 1951: a match of 258 bytes takes 2 bits), so
    // a header that claims more is wrong, and must not cost memory.
    const std::uint64_t bits = std::uint64_t{header_.width} * header_.height * header_.bit_depth *
                               channels_of(header_.color_type);
    if (bits / 8 / 1032 > png.size()) check_png(SPNG_EIDAT_TOO_SHORT, file_);
  }

  const spng_ihdr& header() const { return header_; }
  bool grey() const { return header_.color_type == SPNG_COLOR_TYPE_GRAYSCALE; }

  // Channels of the picture that decode_png8() returns.
  unsigned channels() {
    if (header_.color_type != SPNG_COLOR_TYPE_INDEXED) return channels_of(header_.color_type);
    spng_trns transparency{};
    const int result = spng_get_trns(context_.get(), &transparency);
    if (result != SPNG_ECHUNKAVAIL) check_png(result, file_);
    return result == SPNG_OK ? 4 : 3;
  }

  // Decodes, then reads the rest of the file: the last checksum may be missing though all pixels
  // are there.
  void read(void* pixels, std::size_t bytes, spng_format format, int flags) {
    std::size_t needed = 0;
    check_png(spng_decoded_image_size(context_.get(), format, &needed), file_);
    EN_CHECK_EQ(needed, bytes);
    check_png(spng_decode_image(context_.get(), pixels, bytes, format, flags), file_);
    check_png(spng_decode_chunks(context_.get()), file_);
  }

  // The same row by row; an interlaced file is decoded whole before the first row.
  template <class Take>
  void read_rows(std::size_t row_bytes, spng_format format, int flags, const Take& take) {
    const bool interlaced = header_.interlace_method != SPNG_INTERLACE_NONE;
    std::vector<std::uint8_t> rows(row_bytes * (interlaced ? header_.height : 1));
    if (interlaced) {
      read(rows.data(), rows.size(), format, flags);
    } else {
      check_png(
          spng_decode_image(context_.get(), nullptr, 0, format, flags | SPNG_DECODE_PROGRESSIVE),
          file_);
    }
    for (std::size_t y = 0; y < header_.height; ++y) {
      if (!interlaced) {
        const int result = spng_decode_row(context_.get(), rows.data(), row_bytes);
        if (result != SPNG_EOI) check_png(result, file_);
      }
      take(rows.data() + (interlaced ? y * row_bytes : 0));
    }
    if (!interlaced) check_png(spng_decode_chunks(context_.get()), file_);
  }

  // Of a file that was read. A chunk that cannot be read says nothing.
  void read_notes(PhotoNotes& notes) const {
    spng_exif exif{};
    if (spng_get_exif(context_.get(), &exif) == SPNG_OK) {
      read_exif(bytes_of({exif.data, exif.length}), notes);
    }
    std::uint32_t count = 0;
    if (spng_get_text(context_.get(), nullptr, &count) != SPNG_OK) return;
    std::vector<spng_text> texts(count);
    if (spng_get_text(context_.get(), texts.data(), &count) != SPNG_OK) return;
    for (const spng_text& text : texts) {
      if (std::string_view(text.keyword) == "XML:com.adobe.xmp") {
        notes.xmp.assign(text.text, text.length);
      }
    }
  }

 private:
  const std::string& file_;
  Context context_;
  spng_ihdr header_{};
};

spng_format format_of(const spng_ihdr& header, unsigned channels) {
  if (header.color_type == SPNG_COLOR_TYPE_GRAYSCALE) return SPNG_FMT_G8;
  if (header.color_type == SPNG_COLOR_TYPE_GRAYSCALE_ALPHA) return SPNG_FMT_PNG;
  return channels == 4 ? SPNG_FMT_RGBA8 : SPNG_FMT_RGB8;
}

std::vector<std::uint8_t> encode(const void* pixels, std::size_t bytes, const spng_ihdr& ihdr) {
  const Context context(spng_ctx_new(SPNG_CTX_ENCODER));
  EN_CHECK(context != nullptr);
  spng_ihdr header = ihdr;
  EN_CHECK_EQ(spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1), 0);
  EN_CHECK_EQ(spng_set_ihdr(context.get(), &header), 0);
  EN_CHECK_EQ(spng_encode_image(context.get(), pixels, bytes, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE),
              0);
  std::size_t size = 0;
  int error = 0;
  const std::unique_ptr<void, FreeBytes> png(spng_get_png_buffer(context.get(), &size, &error));
  EN_CHECK_EQ(error, 0);
  const auto* data = static_cast<const std::uint8_t*>(png.get());
  return {data, data + size};
}

spng_ihdr header_for(std::uint32_t width, std::uint32_t height, std::uint32_t channels,
                     std::uint8_t bits) {
  constexpr std::array<std::uint8_t, 4> kTypes{
      SPNG_COLOR_TYPE_GRAYSCALE, SPNG_COLOR_TYPE_GRAYSCALE_ALPHA, SPNG_COLOR_TYPE_TRUECOLOR,
      SPNG_COLOR_TYPE_TRUECOLOR_ALPHA};
  const std::uint32_t most = bits == 8 ? 4 : 1;
  if (channels < 1 || channels > most || width == 0 || height == 0 ||
      std::max(width, height) > kLongestEdge) {
    throw ArgumentError(
        fmt::format("encode_png: {} x {} pixels, {} channels; edges of 1 .. {} and 1 .. {} "
                    "channels of {} bits are allowed",
                    width, height, channels, kLongestEdge, most, bits));
  }
  return {width, height, bits, kTypes[channels - 1], 0, 0, SPNG_INTERLACE_NONE};
}

}  // namespace

Shape png_shape(Bytes png, const std::string& file) {
  Reader reader(png, file);
  const spng_ihdr& header = reader.header();
  return {header.width, header.height, reader.channels(), header.bit_depth == 16 ? 16U : 8U};
}

Image8 detail::decode_png8(Bytes png, const std::string& file, std::uint64_t most,
                           PhotoNotes* notes) {
  Reader reader(png, file);
  const std::uint32_t width = reader.header().width, height = reader.header().height;
  const unsigned channels = reader.channels(), halvings = halvings_to(width, height, most);
  if (halvings > 0 && reader.header().interlace_method != SPNG_INTERLACE_NONE) {
    refuse_whole("an interlaced PNG", width, height, most, file);
  }
  Image8 picture(halved(width, halvings), halved(height, halvings), channels);
  RowShrinker rows({width, height}, {picture.width, picture.height}, channels,
                   picture.pixels.data());
  const std::size_t values = std::size_t{width} * channels;
  if (reader.header().bit_depth == 16) {
    reader.read_rows(2 * values, SPNG_FMT_PNG, 0, [&](const std::uint8_t* row) {
      std::uint8_t* const to = rows.row();
      for (std::size_t k = 0; k < values; ++k) {
        std::uint16_t value = 0;
        std::memcpy(&value, row + 2 * k, sizeof value);
        to[k] = static_cast<std::uint8_t>((std::uint32_t{value} * 255 + 32767) / 65535);
      }
      rows.add(to);
    });
  } else {
    const bool palette = reader.header().color_type == SPNG_COLOR_TYPE_INDEXED;
    reader.read_rows(values, format_of(reader.header(), channels),
                     palette && channels == 4 ? SPNG_DECODE_TRNS : 0,
                     [&](const std::uint8_t* row) { rows.add(row); });
  }
  if (notes != nullptr) reader.read_notes(*notes);
  return picture;
}

Image8 decode_png8(Bytes png, const std::string& file) {
  return detail::decode_png8(png, file, kMostPixels, nullptr);
}

Image16 decode_png16(Bytes png, const std::string& file) {
  Reader reader(png, file);
  const spng_ihdr& header = reader.header();
  if (!reader.grey()) {
    refuse(file, "", "bad-colours", "a PNG in colours; greyscale is allowed here");
  }
  Image16 picture(header.width, header.height, 1);
  if (header.bit_depth == 16) {
    reader.read(picture.pixels.data(), 2 * picture.pixels.size(), SPNG_FMT_PNG, 0);
    return picture;
  }
  std::vector<std::uint8_t> grey(picture.pixels.size());
  reader.read(grey.data(), grey.size(), SPNG_FMT_G8, 0);
  // Values of fewer bits were scaled up to 8 bits, which a division reverses exactly.
  const int scale = 255 / ((1 << header.bit_depth) - 1);
  std::ranges::transform(grey, picture.pixels.begin(),
                         [scale](int value) { return static_cast<std::uint16_t>(value / scale); });
  return picture;
}

std::vector<std::uint8_t> encode_png(const Image8& picture) {
  return encode(picture.pixels.data(), picture.pixels.size(),
                header_for(picture.width, picture.height, picture.channels, 8));
}

std::vector<std::uint8_t> encode_png(const Image16& picture) {
  return encode(picture.pixels.data(), 2 * picture.pixels.size(),
                header_for(picture.width, picture.height, picture.channels, 16));
}

std::vector<std::uint8_t> encode_ids(const Image32& ids) {
  if (ids.pixels.empty() || std::ranges::max(ids.pixels) <= 65535) {
    Image16 grey(ids.width, ids.height, 1);
    std::ranges::transform(ids.pixels, grey.pixels.begin(),
                           [](std::uint32_t id) { return static_cast<std::uint16_t>(id); });
    return encode_png(grey);
  }
  Image8 rgba(ids.width, ids.height, 4);
  for (std::size_t i = 0; i < rgba.pixels.size(); ++i) {
    rgba.pixels[i] = static_cast<std::uint8_t>(ids.pixels[i / 4] >> 8 * (i % 4));
  }
  return encode_png(rgba);
}

Image32 decode_ids(Bytes png, const std::string& file) {
  const Shape shape = png_shape(png, file);
  Image32 ids(shape.width, shape.height, 1);
  if (shape.channels == 1) {
    std::ranges::copy(decode_png16(png, file).pixels, ids.pixels.begin());
    return ids;
  }
  if (shape.channels != 4 || shape.bits != 8) {
    refuse(file, "", "bad-colours",
           fmt::format("{} channels of {} bits, neither greyscale nor RGBA of 8 bits",
                       shape.channels, shape.bits));
  }
  const Image8 rgba = decode_png8(png, file);
  for (std::size_t i = 0; i < rgba.pixels.size(); ++i) {
    ids.pixels[i / 4] |= std::uint32_t{rgba.pixels[i]} << 8 * (i % 4);
  }
  return ids;
}

}  // namespace enfilade::image
