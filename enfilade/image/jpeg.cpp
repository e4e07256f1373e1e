#include <fmt/format.h>
#include <turbojpeg.h>
#include <algorithm>
#include <memory>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/detail/check_size.h"
#include "enfilade/image/detail/to_baseline.h"

namespace enfilade::image {

using namespace detail;

namespace {

struct DestroyHandle {
  void operator()(void* handle) const noexcept { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, DestroyHandle>;
struct FreeBuffer {
  void operator()(unsigned char* buffer) const noexcept { tjFree(buffer); }
};
using Buffer = std::unique_ptr<unsigned char, FreeBuffer>;

// A handle for transforming can also decompress and compress. One per thread, as handles may not be
// shared and take 30 microseconds to create.
Handle& thread_handle() {
  thread_local Handle handle;
  if (handle == nullptr) handle.reset(tjInitTransform());
  EN_CHECK(handle != nullptr);
  return handle;
}

// TurboJPEG decodes damaged data too, grey from the damage on, and reports a warning. All warnings
// are treated as errors: only the first one is reported, so a harmless one could hide that the file
// is cut off.
void check(int result, const std::string& file) {
  if (result == 0) return;
  Handle& handle = thread_handle();
  const std::string words = tjGetErrorStr2(handle.get());
  const bool damaged = tjGetErrorCode(handle.get()) == TJERR_WARNING;
  handle.reset();  // TurboJPEG 2.1 would continue in the middle of a header that it failed to read
  refuse(
      file, "", damaged ? "damaged-jpeg" : "bad-jpeg",
      fmt::format("{}: {}", damaged ? "the JPEG is damaged" : "no JPEG that can be read", words));
}

// A hostile progressive file may have thousands of scans.
constexpr int kFlags = TJFLAG_LIMITSCANS;

struct Header {
  int width = 0, height = 0, subsampling = 0, colours = 0;
};

Header read_header(Bytes jpeg, const std::string& file) {
  Header header;
  check(tjDecompressHeader3(thread_handle().get(), jpeg.data(), jpeg.size(), &header.width,
                            &header.height, &header.subsampling, &header.colours),
        file);
  check_size(static_cast<std::uint64_t>(header.width), static_cast<std::uint64_t>(header.height),
             file);
  if (header.colours == TJCS_CMYK || header.colours == TJCS_YCCK) {
    refuse(file, "", "bad-colours", "a JPEG in CMYK (for printing); RGB and greyscale are allowed");
  }
  return header;
}

Shape shape_of(const Header& header) {
  return {static_cast<std::uint32_t>(header.width), static_cast<std::uint32_t>(header.height),
          header.colours == TJCS_GRAY ? 1U : 3U, 8};
}

void decode(Bytes jpeg, const Header& header, std::uint8_t* rgb, const std::string& file) {
  check(tjDecompress2(thread_handle().get(), jpeg.data(), jpeg.size(), rgb, header.width, 0,
                      header.height, TJPF_RGB, kFlags),
        file);
}

}  // namespace

std::vector<std::uint8_t> detail::to_baseline(Bytes jpeg, const std::string& file) {
  read_header(jpeg, file);  // refuses what no reader takes
  tjtransform transform{};
  transform.op = TJXOP_NONE;
  transform.options = TJXOPT_COPYNONE;
  unsigned char* data = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): TurboJPEG's type
  const int result = tjTransform(thread_handle().get(), jpeg.data(), jpeg.size(), 1, &data, &size,
                                 &transform, kFlags);
  const Buffer owner(data);
  check(result, file);
  return {data, data + size};
}

Shape jpeg_shape(Bytes jpeg, const std::string& file) { return shape_of(read_header(jpeg, file)); }

Image8 decode_jpeg(Bytes jpeg, const std::string& file) {
  const Header header = read_header(jpeg, file);
  const Shape shape = shape_of(header);
  Image8 picture(shape.width, shape.height, 3);
  decode(jpeg, header, picture.pixels.data(), file);
  return picture;
}

void decode_jpeg(Bytes jpeg, std::uint32_t width, std::uint32_t height, std::span<std::uint8_t> rgb,
                 const std::string& file) {
  EN_CHECK_EQ(rgb.size(), std::size_t{3} * width * height);
  const Header header = read_header(jpeg, file);
  const Shape shape = shape_of(header);
  if (shape.width != width || shape.height != height) {
    throw ArgumentError(fmt::format("{}: {} x {} pixels, not the {} x {} that were asked for", file,
                                    shape.width, shape.height, width, height));
  }
  decode(jpeg, header, rgb.data(), file);
}

std::vector<std::uint8_t> encode_jpeg(const Image8& picture, int quality, bool full_chroma) {
  const bool grey = picture.channels == 1;
  if ((!grey && picture.channels != 3) || picture.width == 0 || picture.height == 0 ||
      std::max(picture.width, picture.height) > kLongestEdge || quality < 1 || quality > 100) {
    throw ArgumentError(fmt::format(
        "encode_jpeg: {} x {} pixels, {} channels, quality {}; edges of 1 .. {}, 1 or 3 "
        "channels and qualities of 1 .. 100 are allowed",
        picture.width, picture.height, picture.channels, quality, kLongestEdge));
  }
  unsigned char* data = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): TurboJPEG's type
  const int result = tjCompress2(
      thread_handle().get(), picture.pixels.data(), static_cast<int>(picture.width), 0,
      static_cast<int>(picture.height), grey ? TJPF_GRAY : TJPF_RGB, &data, &size,
      grey ? TJSAMP_GRAY : (full_chroma ? TJSAMP_444 : TJSAMP_420), quality, TJFLAG_ACCURATEDCT);
  const Buffer owner(data);
  EN_CHECK_EQ(result, 0);
  return {data, data + size};
}

std::optional<std::array<std::vector<std::uint8_t>, kCubeFaces>> cut_jpeg_strip(
    Bytes jpeg, const std::string& file) {
  const Header header = read_header(jpeg, file);
  const int size = header.height;
  if (std::int64_t{header.width} != 6 * std::int64_t{size} ||
      size % tjMCUWidth[header.subsampling] != 0) {
    return std::nullopt;
  }
  std::array<tjtransform, kCubeFaces> transforms{};
  std::array<unsigned char*, kCubeFaces> data{};
  std::array<unsigned long, kCubeFaces> sizes{};  // NOLINT(google-runtime-int): TurboJPEG's type
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    transforms[k].r = {static_cast<int>(k) * size, 0, size, size};
    transforms[k].op = TJXOP_NONE;
    transforms[k].options = TJXOPT_CROP | TJXOPT_PERFECT | TJXOPT_COPYNONE;
  }
  const int result =
      tjTransform(thread_handle().get(), jpeg.data(), jpeg.size(), static_cast<int>(kCubeFaces),
                  data.data(), sizes.data(), transforms.data(), kFlags);
  std::array<Buffer, kCubeFaces> owners;
  for (std::size_t k = 0; k < kCubeFaces; ++k) owners[k].reset(data[k]);
  check(result, file);
  std::array<std::vector<std::uint8_t>, kCubeFaces> faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) faces[k].assign(data[k], data[k] + sizes[k]);
  return faces;
}

}  // namespace enfilade::image
