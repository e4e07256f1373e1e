#include "enfilade/scan/zip_writer.h"

#include <fmt/format.h>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <string_view>

#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"

namespace enfilade::scan {
namespace {

// The layout is that of PKWARE's APPNOTE.TXT, sections 4.3 and 4.4.
constexpr std::uint32_t kLocalHeader = 0x04034b50, kListEntry = 0x02014b50, kListEnd = 0x06054b50;
constexpr std::uint16_t kVersion = 20, kUtf8Names = 0x0800, kDeflated = 8;
constexpr std::uint16_t kFirstDay = 0x0021;  // 1980-01-01
// Around the deflated bytes, gzip has a header of this size and, behind, checksum and size.
constexpr std::size_t kGzipHeader = 10, kGzipTrailer = 8, kChecksum = 4;

void put16(std::string& bytes, std::size_t value) {
  for (const unsigned shift : {0U, 8U}) bytes += static_cast<char>(value >> shift & 0xffU);
}

void put32(std::string& bytes, std::size_t value) {
  for (const unsigned shift : {0U, 8U, 16U, 24U}) {
    bytes += static_cast<char>(value >> shift & 0xffU);
  }
}

void check(std::span<const ZipEntry> entries) {
  constexpr std::size_t kMost16 = std::numeric_limits<std::uint16_t>::max();
  if (entries.size() > kMost16) {
    throw ArgumentError(fmt::format("{} files in a zip; {} at most", entries.size(), kMost16));
  }
  std::set<std::string_view> names;
  for (const ZipEntry& entry : entries) {
    if (entry.name.empty() || entry.name.size() > kMost16) {
      throw ArgumentError(fmt::format("a name of {} bytes in a zip; 1 to {} are allowed",
                                      entry.name.size(), kMost16));
    }
    if (!names.insert(entry.name).second) {
      throw ArgumentError(fmt::format("{:?} is twice in a zip", entry.name));
    }
  }
}

void check_size(std::size_t bytes) {
  if (bytes >= std::numeric_limits<std::uint32_t>::max()) {
    throw ArgumentError(fmt::format("a zip of {} bytes; less than 4 GiB is allowed", bytes));
  }
}

// What the header of an entry and its place in the list have in common.
std::string common_fields(const ZipEntry& entry, std::string_view checksum, std::size_t packed) {
  std::string bytes;
  put16(bytes, kVersion);
  put16(bytes, kUtf8Names);
  put16(bytes, kDeflated);
  put16(bytes, 0);  // midnight
  put16(bytes, kFirstDay);
  bytes += checksum;
  put32(bytes, packed);
  put32(bytes, entry.content.size());
  put16(bytes, entry.name.size());
  put16(bytes, 0);  // no extra fields
  return bytes;
}

}  // namespace

std::string zip(std::span<const ZipEntry> entries) {
  check(entries);
  std::string bytes, list;
  for (const ZipEntry& entry : entries) {
    check_size(entry.content.size());
    const std::string gzipped = gzip(entry.content, 6);
    const std::string_view whole = gzipped;
    const std::size_t packed = whole.size() - kGzipHeader - kGzipTrailer;
    const std::string_view checksum = whole.substr(kGzipHeader + packed, kChecksum);
    const std::string fields = common_fields(entry, checksum, packed);
    check_size(bytes.size());
    const std::size_t place = bytes.size();
    put32(bytes, kLocalHeader);
    bytes.append(fields).append(entry.name).append(whole.substr(kGzipHeader, packed));
    put32(list, kListEntry);
    put16(list, kVersion);
    list += fields;
    put16(list, 0);  // no comment
    put16(list, 0);  // first disk
    put16(list, 0);  // attributes
    put32(list, 0);
    put32(list, place);
    list += entry.name;
  }
  const std::size_t place = bytes.size();
  check_size(place + list.size());
  bytes += list;
  put32(bytes, kListEnd);
  put16(bytes, 0);
  put16(bytes, 0);
  put16(bytes, entries.size());
  put16(bytes, entries.size());
  put32(bytes, list.size());
  put32(bytes, place);
  put16(bytes, 0);  // no comment
  return bytes;
}

}  // namespace enfilade::scan
