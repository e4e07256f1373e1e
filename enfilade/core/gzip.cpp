#include "enfilade/core/gzip.h"

#include <fmt/format.h>
#include <zlib.h>
#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/utf8.h"

namespace enfilade {
namespace {

constexpr int kGzipWindow = 15 + 16;        // zlib: + 16 selects the gzip format
constexpr unsigned char kFirstByte = 0x1F;  // of a member
constexpr std::size_t kPiece = 1U << 15U;
constexpr std::size_t kMostRatio = 1032;  // bytes that deflate can say with one

// zlib takes a pointer to mutable bytes, but only reads them.
Bytef* bytes_of(std::string_view text) {
  return reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
}

// The size of the last member's text modulo 2^32, which the last four bytes are; they may lie.
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

std::filesystem::path find_text_file(const std::filesystem::path& path) {
  std::error_code ignored;  // who reads the file says it
  if (std::filesystem::exists(path, ignored)) return path;
  std::filesystem::path other = path;
  if (path.extension() == ".gz") {
    other.replace_extension();
  } else {
    other += ".gz";
  }
  return std::filesystem::exists(other, ignored) ? other : path;
}

std::optional<std::string> name_before(const std::filesystem::path& file, std::string_view ending) {
  constexpr std::string_view kPacked = ".gz";
  std::string name = file.filename().string();
  if (name.ends_with(kPacked)) name.resize(name.size() - kPacked.size());
  if (!name.ends_with(ending)) return std::nullopt;
  name.resize(name.size() - ending.size());
  return name;
}

std::string read_text_file(const std::filesystem::path& path, std::size_t most) {
  const std::filesystem::path found = find_text_file(path);
  std::string content = read_file(found, most);
  if (!content.starts_with(kGzipMark)) return content;
  try {
    return gunzip(content,
                  std::min(most, std::max(kAlwaysUnpacked, kMostPacking * content.size())));
  } catch (const Error& error) {
    throw FileError(fmt::format("{}: cannot unpack: {}", found.string(), error.what()));
  }
}

std::string text_beginning(const std::filesystem::path& path, std::size_t most) {
  const std::size_t wanted = most + kByteOrderMark.size();
  const std::filesystem::path found = find_text_file(path);
  check_plain_file(found);
  std::ifstream file(found, std::ios::binary);
  const auto read = [&](std::size_t bytes) {
    std::string piece(bytes, '\0');
    file.read(piece.data(), std::ssize(piece));
    if (file.bad() || !file.is_open()) {
      throw FileError(fmt::format("{}: cannot be read", path.string()));
    }
    piece.resize(static_cast<std::size_t>(file.gcount()));
    return piece;
  };
  std::string content = read(wanted);
  if (content.starts_with(kGzipMark)) {
    std::string text;
    Gunzip unpacked;
    const auto take = [&](std::string_view piece) {
      text += piece.substr(0, wanted - text.size());
    };
    try {
      for (; !content.empty() && text.size() < wanted; content = read(kPiece)) {
        unpacked.add(content, take);
      }
    } catch (const FileError&) {
      throw;
    } catch (const Error&) {
      // It is damaged: who reads the whole file says so.
    }
    content = std::move(text);
  }
  return std::string(without_byte_order_mark(content).substr(0, most));
}

struct Gunzip::Impl {
  z_stream stream{};
  bool ended = false;  // a member has, and no further one has begun
  std::array<char, kPiece> piece{};

  // Behind a member: skips zeros, and begins the next one if there is a byte of it.
  void begin_next() {
    while (stream.avail_in > 0 && *stream.next_in == 0) {
      ++stream.next_in;
      --stream.avail_in;
    }
    if (stream.avail_in == 0) return;
    if (*stream.next_in != kFirstByte) throw Error("bytes after the end of the compressed text");
    EN_CHECK_EQ(inflateReset(&stream), Z_OK);
    ended = false;
  }
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
    if (impl_->ended) {
      impl_->begin_next();
      if (impl_->ended) return;
    }
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

TextFile::TextFile(const std::filesystem::path& path, std::size_t most) {
  const std::filesystem::path found = find_text_file(path);
  // What is small is read at once: mapping costs more. So are pipes, which have no size. What is
  // too large is refused there.
  constexpr std::uintmax_t kLeastMapped = std::uintmax_t{1} << 20U;
  std::error_code code;
  const bool plain = std::filesystem::is_regular_file(found, code);
  const std::uintmax_t size = plain ? std::filesystem::file_size(found, code) : 0;
  if (!code && size >= kLeastMapped && size <= most) {
    mapped_.emplace(found);
    const auto bytes = mapped_->bytes();
    text_ = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    if (!text_.starts_with(kGzipMark)) return;
    mapped_.reset();
  }
  read_ = read_text_file(found, most);
  text_ = read_;
}

}  // namespace enfilade
