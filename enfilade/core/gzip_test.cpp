#include "enfilade/core/gzip.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::string text_of(std::size_t bytes) {
  std::string text;
  for (std::size_t k = 0; text.size() < bytes; ++k) text += std::to_string(k * 7919);
  text.resize(bytes);
  return text;
}

TEST(Gzip, IsUndoneByGunzip) {
  for (const std::size_t bytes : {0UL, 1UL, 32'768UL, 32'769UL, 1'000'000UL}) {
    const std::string text = text_of(bytes);
    for (const int level : {1, 9}) EXPECT_EQ(gunzip(gzip(text, level), bytes), text) << bytes;
  }
  const std::string zeros(3'000'000, '\0');
  EXPECT_EQ(gunzip(gzip(zeros, 9), zeros.size()), zeros);
}

TEST(Gzip, WhatIsLongerThanAllowedOrDamagedIsRefused) {
  const std::string text = text_of(100'000);
  const std::string packed = gzip(text, 6);
  EXPECT_THROW(gunzip(packed, text.size() - 1), Error);
  EXPECT_THROW(gunzip(gzip(std::string(10'000'000, ' '), 9), 1'000'000), Error);
  EXPECT_THROW(gunzip("", 10), Error);
  EXPECT_THROW(gunzip(text, text.size()), Error);
  EXPECT_THROW(gunzip(packed.substr(0, packed.size() - 1), text.size()), Error);
  EXPECT_THROW(gunzip(packed + "x", text.size()), Error);
  std::string damaged = packed;
  damaged[packed.size() / 2] = static_cast<char>(~damaged[packed.size() / 2]);
  EXPECT_THROW(gunzip(damaged, 2 * text.size()), Error);
}

TEST(Gzip, IsUnpackedByTheByte) {
  const std::string text = text_of(200'000);
  std::string unpacked;
  Gunzip gunzip;
  for (const char c : gzip(text, 6)) {
    EXPECT_FALSE(gunzip.ended());
    gunzip.add({&c, 1}, [&unpacked](std::string_view piece) {
      EXPECT_LE(piece.size(), 32'768U);
      unpacked += piece;
    });
  }
  EXPECT_TRUE(gunzip.ended());
  EXPECT_EQ(unpacked, text);
}

TEST(Gzip, TextFilesAreReadPackedOrPlain) {
  const tests::TemporaryFolder folder("gzip");
  const std::string text = text_of(50'000);
  write_file_atomically(folder.path() / "plain.json", text);
  write_file_atomically(folder.path() / "packed.json.gz", gzip(text, 6));
  EXPECT_EQ(read_text_file(folder.path() / "plain.json"), text);
  EXPECT_EQ(read_text_file(folder.path() / "packed.json.gz"), text);
  write_file_atomically(folder.path() / "cut.json.gz", gzip(text, 6).substr(0, 100));
  EXPECT_THAT([&] { read_text_file(folder.path() / "cut.json.gz"); },
              ThrowsMessage<FileError>(HasSubstr("cut.json.gz: cannot unpack")));
  EXPECT_THAT([&] { read_text_file(folder.path() / "packed.json.gz", text.size() - 1); },
              ThrowsMessage<FileError>(HasSubstr("more than 49999 bytes")));
}

}  // namespace EN_UNIT
}  // namespace enfilade
