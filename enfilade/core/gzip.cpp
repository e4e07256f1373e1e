#include "enfilade/core/gzip.h"

#include <fmt/format.h>
#include <zlib.h>
#include <algorithm>
#include <array>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"

namespace enfilade {
namespace {

constexpr int kGzipWindow = 15 + 16;  // zlib: + 16 selects the gzip format
constexpr std::size_t kPiece = 1U << 15U;
constexpr std::size_t kMostRatio = 1032;  // bytes that deflate can say with one

// zlib takes a pointer to mutable bytes, but only reads them.
Bytef* bytes_of(std::string_view text) {
  return reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
}

// The size of the text modulo 2^32, which the last four bytes are; they may lie.
std::size_t claimed_size(std::string_view packed) {
  std::size_t size = 0;
  if (packed.size() < 4) return size;
  for (std::size_t k = 4; k > 0; --k) {
    size = (size << 8U) | static_cast<unsigned char>(packed[packed.size() - 5 + k]);
  }
  return size;
}

}  // namespace

std::string gzip(std::string_view text, int level) {
  z_stream stream{};
  EN_CHECK_EQ(deflateInit2(&stream, level, Z_DEFLATED, kGzipWindow, 8, Z_DEFAULT_STRATEGY), Z_OK);
  stream.next_in = bytes_of(text);
  stream.avail_in = static_cast<uInt>(text.size());
  std::string packed;
  std::array<char, kPiece> piece;
  int status = Z_OK;
  while (status == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = kPiece;
    status = deflate(&stream, Z_FINISH);
    packed.append(piece.data(), kPiece - stream.avail_out);
  }
  deflateEnd(&stream);
  EN_CHECK_EQ(status, Z_STREAM_END);
  return packed;
}

std::string gunzip(std::string_view packed, std::size_t most) {
  std::string text;
  text.reserve(std::min({claimed_size(packed), most, kMostRatio * packed.size()}));
  Gunzip unpacked;
  unpacked.add(packed, [&](std::string_view piece) {
    if (piece.size() > most - text.size()) {
      throw Error(fmt::format("the compressed text has more than {} bytes", most));
    }
    text += piece;
  });
  if (!unpacked.ended()) throw Error("compressed bytes are damaged");
  return text;
}

std::string read_text_file(const std::filesystem::path& path, std::size_t most) {
  std::string content = read_file(path);
  if (!content.starts_with("\x1f\x8b")) return content;
  try {
    return gunzip(content, most);
  } catch (const Error& error) {
    throw FileError(fmt::format("{}: cannot unpack: {}", path.string(), error.what()));
  }
}

struct Gunzip::Impl {
  z_stream stream{};
  bool ended = false;
  std::array<char, kPiece> piece{};
};

Gunzip::Gunzip() : impl_(std::make_unique<Impl>()) {
  EN_CHECK_EQ(inflateInit2(&impl_->stream, kGzipWindow), Z_OK);
}

Gunzip::~Gunzip() { inflateEnd(&impl_->stream); }

bool Gunzip::ended() const noexcept { return impl_->ended; }

void Gunzip::add(std::string_view packed, const Take& take) {
  z_stream& stream = impl_->stream;
  stream.next_in = bytes_of(packed);
  stream.avail_in = static_cast<uInt>(packed.size());
  // Output that did not fit into the last piece comes without further input.
  for (bool full = false; stream.avail_in > 0 || full;) {
    if (impl_->ended) throw Error("bytes after the end of the compressed text");
    stream.next_out = reinterpret_cast<Bytef*>(impl_->piece.data());
    stream.avail_out = kPiece;
    const int status = inflate(&stream, Z_NO_FLUSH);
    if (status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR) {
      throw Error("compressed bytes are damaged");
    }
    impl_->ended = status == Z_STREAM_END;
    full = stream.avail_out == 0 && !impl_->ended;
    if (stream.avail_out < kPiece) take({impl_->piece.data(), kPiece - stream.avail_out});
  }
}

}  // namespace enfilade
