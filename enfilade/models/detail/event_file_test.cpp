#include "enfilade/models/detail/event_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::models::detail {
namespace EN_UNIT {

namespace fs = std::filesystem;

// A decoder that shares nothing with the writer: a CRC bit by bit, fields of any message by their
// numbers, as protobuf's encoding and TFRecords are described.
std::uint32_t slow_crc32c(std::string_view bytes) {
  std::uint32_t remainder = 0xffffffff;
  for (const char byte : bytes) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      const bool in = (static_cast<unsigned char>(byte) >> bit & 1U) != (remainder & 1U);
      remainder = remainder / 2 ^ (in ? 0x82f63b78U : 0U);
    }
  }
  return remainder ^ 0xffffffff;
}

std::uint32_t unmasked(std::uint32_t masked) {
  const std::uint32_t rotated = masked - 0xa282ead8U;
  return (rotated >> 17U) | (rotated << 15U);
}

template <class T>
T fixed(std::string_view bytes, std::size_t at) {
  if (at + sizeof(T) > bytes.size()) throw std::runtime_error("cut off");
  T value;  // this test, like TFRecords, is little-endian
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

std::vector<std::string> records(const std::string& file) {
  std::vector<std::string> all;
  for (std::size_t at = 0; at < file.size();) {
    const auto size = fixed<std::uint64_t>(file, at);
    EXPECT_EQ(unmasked(fixed<std::uint32_t>(file, at + 8)), slow_crc32c(file.substr(at, 8)));
    const std::string data = file.substr(at + 12, size);
    EXPECT_EQ(unmasked(fixed<std::uint32_t>(file, at + 12 + size)), slow_crc32c(data));
    all.push_back(data);
    at += size + 16;
  }
  return all;
}

// Field number -> the bytes of its value; each stands once in what we read.
std::map<int, std::string> fields(std::string_view message) {
  std::map<int, std::string> found;
  std::size_t at = 0;
  const auto varint = [&] {
    std::uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
      const auto byte = static_cast<unsigned char>(message.at(at++));
      value |= std::uint64_t{byte & 0x7fU} << shift;
      if (byte < 0x80) return value;
    }
  };
  while (at < message.size()) {
    const std::uint64_t key = varint();
    std::string& value = found[static_cast<int>(key / 8)];
    if (key % 8 == 0) {
      const std::uint64_t number = varint();
      value.assign(reinterpret_cast<const char*>(&number), sizeof number);
      continue;
    }
    const std::size_t size = key % 8 == 1 ? 8 : key % 8 == 5 ? 4 : varint();
    value = message.substr(at, size);
    at += size;
  }
  return found;
}

TEST(Crc32c, HasTheValuesOfTheStandard) {
  EXPECT_EQ(crc32c("123456789"), 0xe3069283U);
  EXPECT_EQ(crc32c(std::string(32, '\0')), 0x8a9136aaU);    // RFC 3720, B.4
  EXPECT_EQ(crc32c(std::string(32, '\xff')), 0x62a8ab43U);  // likewise
}

TEST(EventFile, IsReadBackByADecoderOfItsOwn) {
  const tests::TemporaryFolder folder("events");
  {
    EventFile events(folder.path(), 1700000000.25);
    events.add({"val_seen/loss", 1.5, 300, 1700000001.5});
    events.add({"train/loss", -2, 20'000'000'000, 1700000002});
  }
  const fs::path file = folder.path() / "events.out.tfevents.1700000000.enfilade";
  const auto all = records(read_file(file));
  ASSERT_EQ(all.size(), 3U);
  auto version = fields(all[0]);
  EXPECT_EQ(fixed<double>(version[1], 0), 1700000000.25);
  EXPECT_EQ(version[3], "brain.Event:2");
  auto event = fields(all[1]);
  EXPECT_EQ(fixed<double>(event[1], 0), 1700000001.5);
  EXPECT_EQ(fixed<std::uint64_t>(event[2], 0), 300U);
  auto value = fields(fields(event[5])[1]);
  EXPECT_EQ(value[1], "val_seen/loss");
  EXPECT_EQ(fixed<float>(value[2], 0), 1.5F);
  auto last = fields(all[2]);
  EXPECT_EQ(fixed<std::uint64_t>(last[2], 0), 20'000'000'000U);
  EXPECT_EQ(fixed<float>(fields(fields(last[5])[1])[2], 0), -2.0F);
}

}  // namespace EN_UNIT
}  // namespace enfilade::models::detail
