#include "enfilade/models/detail/event_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <string>
#include <system_error>

#include "enfilade/core/errors.h"

namespace enfilade::models::detail {
namespace {

constexpr std::uint32_t kPolynomial = 0x82f63b78;  // Castagnoli's, bits reversed
constexpr std::uint32_t kMaskDelta = 0xa282ead8;   // TFRecords store masked CRCs

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? kPolynomial : 0);
    table[i] = crc;
  }
  return table;
}

template <class T>
void put_fixed(std::string& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) out += static_cast<char>(value >> (8 * i) & 0xff);
}

void put_varint(std::string& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7U) out += static_cast<char>((value & 0x7f) | 0x80);
  out += static_cast<char>(value);
}

// reference: protobuf's encoding. Kinds of fields: 0 varint, 1 eight bytes, 2 text, 5 four bytes
void put_key(std::string& out, std::uint64_t field, std::uint64_t kind) {
  put_varint(out, field << 3U | kind);
}

void put_text(std::string& out, std::uint64_t field, std::string_view text) {
  put_key(out, field, 2);
  put_varint(out, text.size());
  out += text;
}

void put_double(std::string& out, std::uint64_t field, double value) {
  put_key(out, field, 1);
  put_fixed(out, std::bit_cast<std::uint64_t>(value));
}

std::uint32_t masked_crc(std::string_view bytes) {
  return std::rotr(crc32c(bytes), 15) + kMaskDelta;
}

}  // namespace

std::uint32_t crc32c(std::string_view bytes) noexcept {
  static constexpr std::array<std::uint32_t, 256> kTable = crc_table();
  std::uint32_t crc = 0xffffffff;
  for (const char byte : bytes) {
    crc = (crc >> 8U) ^ kTable[(crc ^ static_cast<unsigned char>(byte)) & 0xff];
  }
  return ~crc;
}

EventFile::EventFile(const std::filesystem::path& folder, double time)
    : file_(folder / fmt::format("{}{:010.0f}.enfilade", kPrefix, time)) {
  // Event: 1 wall_time, 2 step, 3 file_version, 5 summary.
  std::string event;
  put_double(event, 1, time);
  put_text(event, 3, "brain.Event:2");
  write_record(event);
}

void EventFile::add(const Scalar& scalar) {
  std::string value;  // Summary.Value: 1 tag, 2 simple_value
  put_text(value, 1, scalar.tag);
  put_key(value, 2, 5);
  put_fixed(value, std::bit_cast<std::uint32_t>(static_cast<float>(scalar.value)));
  std::string summary;  // Summary: 1 value
  put_text(summary, 1, value);
  std::string event;
  put_double(event, 1, scalar.time);
  put_key(event, 2, 0);
  put_varint(event, scalar.step);
  put_text(event, 5, summary);
  write_record(event);
}

void EventFile::write_record(std::string_view event) {
  std::string record;
  put_fixed(record, std::uint64_t{event.size()});
  put_fixed(record, masked_crc(record));
  record += event;
  put_fixed(record, masked_crc(event));
  file_.write(record);
}

namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int reason) {
  throw FileError(
      fmt::format("{}: cannot write: {}", path.string(), std::generic_category().message(reason)));
}

}  // namespace

AppendFile::AppendFile(const std::filesystem::path& path) : path_(path) {
  const int file =
      ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (file < 0) fail(path_, errno);
  file_.reset(::fdopen(file, "ab"));
  if (!file_) fail(path_, errno);
}

void AppendFile::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size() ||
      std::fflush(file_.get()) != 0) {
    fail(path_, errno);
  }
}

}  // namespace enfilade::models::detail
