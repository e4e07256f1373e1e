#include "enfilade/service/detail/gzip.h"

#include <zlib.h>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"

namespace enfilade::service::detail {
namespace {

constexpr int kGzipWindow = 15 + 16;  // zlib: + 16 selects the gzip format

// zlib takes a pointer to mutable bytes, but only reads them.
Bytef* bytes_of(std::string_view text) {
  return reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
}

}  // namespace

std::string gzip(std::string_view text, int level) {
  z_stream stream{};
  EN_CHECK_EQ(deflateInit2(&stream, level, Z_DEFLATED, kGzipWindow, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string packed(deflateBound(&stream, text.size()), '\0');
  stream.next_in = bytes_of(text);
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EN_CHECK_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

std::string gunzip(std::string_view packed) {
  z_stream stream{};
  EN_CHECK_EQ(inflateInit2(&stream, kGzipWindow), Z_OK);
  stream.next_in = bytes_of(packed);
  stream.avail_in = static_cast<uInt>(packed.size());
  std::string text;
  int status = Z_OK;
  while (status == Z_OK) {
    constexpr std::size_t kPiece = 1 << 18;
    text.resize(stream.total_out + kPiece);
    stream.next_out = reinterpret_cast<Bytef*>(text.data() + stream.total_out);
    stream.avail_out = kPiece;
    status = inflate(&stream, Z_NO_FLUSH);
  }
  text.resize(stream.total_out);
  inflateEnd(&stream);
  if (status != Z_STREAM_END) throw Error("compressed bytes are damaged");
  return text;
}

}  // namespace enfilade::service::detail
