#include <fmt/format.h>
#include <turbojpeg.h>
#include <algorithm>
#include <memory>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/detail/baseline_jpeg.h"
#include "enfilade/image/detail/check_size.h"
#include "enfilade/image/detail/libjpeg.h"
#include "enfilade/image/detail/row_shrinker.h"

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

// TurboJPEG 2.1 would continue in the middle of a header that it failed to read.
void forget_failure() { thread_handle().reset(); }

// A hostile progressive file may have thousands of scans.
constexpr int kFlags = TJFLAG_LIMITSCANS;

struct Header {
  std::uint32_t width = 0, height = 0, channels = 0;  // channels: 4 are CMYK
  int subsampling = -1;                               // TurboJPEG's, -1 where it reads no header
  bool is_plain() const { return subsampling >= 0 && channels != 4; }  // for TurboJPEG
};

Header read_header(Bytes jpeg, const std::string& file) {
  int width = 0, height = 0, subsampling = 0, colours = 0;
  if (tjDecompressHeader3(thread_handle().get(), jpeg.data(), jpeg.size(), &width, &height,
                          &subsampling, &colours) != 0) {
    forget_failure();
    const LibJpeg careful(jpeg, file);
    return {careful.width(), careful.height(), careful.channels(), -1};
  }
  check_size(static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height), file);
  const bool cmyk = colours == TJCS_CMYK || colours == TJCS_YCCK;
  return {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height),
          cmyk ? 4U : (colours == TJCS_GRAY ? 1U : 3U), subsampling};
}

// TurboJPEG decodes damaged data too, grey from the damage on, and reports the first warning alone.
// A harmless one could hide that the file is cut off. So libjpeg decodes such a file once more.
void decode(Bytes jpeg, const Header& header, std::uint8_t* rgb, const std::string& file,
            std::vector<Diagnostic>* findings, unsigned halvings = 0) {
  const bool plain = header.is_plain() && halvings == 0;
  if (plain && tjDecompress2(thread_handle().get(), jpeg.data(), jpeg.size(), rgb,
                             static_cast<int>(header.width), 0, static_cast<int>(header.height),
                             TJPF_RGB, kFlags) == 0) {
    return;
  }
  if (plain) forget_failure();
  LibJpeg careful(jpeg, file);
  careful.decode(rgb, halvings);
  if (findings == nullptr) return;
  for (Diagnostic& one : careful.findings()) findings->push_back(std::move(one));
}

// Of a transform of a file with a header for TurboJPEG. False if it reads the file, and cannot
// transform it.
bool check_transform(int result, Bytes jpeg, const std::string& file) {
  if (result == 0) return true;
  const bool warned = tjGetErrorCode(thread_handle().get()) == TJERR_WARNING;
  forget_failure();
  LibJpeg(jpeg, file).check();
  return warned;
}

}  // namespace

std::optional<std::vector<std::uint8_t>> detail::to_baseline(Bytes jpeg, const std::string& file) {
  if (!read_header(jpeg, file).is_plain()) return std::nullopt;
  tjtransform transform{};
  transform.op = TJXOP_NONE;
  transform.options = TJXOPT_COPYNONE;
  unsigned char* data = nullptr;
  unsigned long size = 0;  // NOLINT(google-runtime-int): TurboJPEG's type
  const int result = tjTransform(thread_handle().get(), jpeg.data(), jpeg.size(), 1, &data, &size,
                                 &transform, kFlags);
  const Buffer owner(data);
  if (!check_transform(result, jpeg, file) || data == nullptr) return std::nullopt;
  return std::vector<std::uint8_t>(data, data + size);
}

Shape jpeg_shape(Bytes jpeg, const std::string& file) {
  const Header header = read_header(jpeg, file);
  return {header.width, header.height, header.channels == 1 ? 1U : 3U, 8};
}

Image8 detail::decode_jpeg(Bytes jpeg, const std::string& file, std::uint64_t most,
                           std::vector<Diagnostic>* findings) {
  const Header header = read_header(jpeg, file);
  const unsigned halvings = halvings_to(header.width, header.height, most);
  if (halvings > 0 && LibJpeg(jpeg, file).has_several_scans()) {
    refuse_whole("a progressive JPEG", header.width, header.height, most, file);
  }
  Image8 picture(halved(header.width, halvings), halved(header.height, halvings), 3);
  decode(jpeg, header, picture.pixels.data(), file, findings, halvings);
  return picture;
}

Image8 decode_jpeg(Bytes jpeg, const std::string& file, std::vector<Diagnostic>* findings) {
  return detail::decode_jpeg(jpeg, file, kMostPixels, findings);
}

void decode_jpeg(Bytes jpeg, std::uint32_t width, std::uint32_t height, std::span<std::uint8_t> rgb,
                 const std::string& file) {
  EN_CHECK_EQ(rgb.size(), std::size_t{3} * width * height);
  const Header header = read_header(jpeg, file);
  if (header.width != width || header.height != height) {
    throw ArgumentError(fmt::format("{}: {} x {} pixels, not the {} x {} that were asked for", file,
                                    header.width, header.height, width, height));
  }
  decode(jpeg, header, rgb.data(), file, nullptr);
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
  if (!header.is_plain() || header.width != 6 * std::uint64_t{header.height}) return std::nullopt;
  const auto size = static_cast<int>(header.height);
  if (size % tjMCUWidth[header.subsampling] != 0) return std::nullopt;
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
  if (!check_transform(result, jpeg, file)) return std::nullopt;
  std::array<std::vector<std::uint8_t>, kCubeFaces> faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) faces[k].assign(data[k], data[k] + sizes[k]);
  return faces;
}

}  // namespace enfilade::image
