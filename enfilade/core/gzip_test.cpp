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
  EXPECT_THROW(gunzip(gzip(std::string(8'000'000, ' '), 9), 1'000'000), Error);
  EXPECT_THROW(gunzip("", 10), Error);
  EXPECT_THROW(gunzip(text, text.size()), Error);
  EXPECT_THROW(gunzip(packed.substr(0, packed.size() - 1), text.size()), Error);
  EXPECT_THROW(gunzip(packed + "x", text.size()), Error);
  std::string damaged = packed;
  damaged[packed.size() / 2] = static_cast<char>(~damaged[packed.size() / 2]);
  EXPECT_THROW(gunzip(damaged, 2 * text.size()), Error);
}

// As `cat a.gz b.gz`, `gzip -c >> f.gz`, bgzip (which ends with an empty one) and pigz make them.
TEST(Gzip, SeveralMembersAreOneText) {
  const std::string text = text_of(100'000), more = text_of(40'000);
  const std::string two = gzip(text, 6) + gzip(more, 1);
  EXPECT_EQ(gunzip(two, 140'000), text + more);
  EXPECT_EQ(gunzip(two + gzip("", 6), 140'000), text + more);
  EXPECT_EQ(gunzip(gzip("", 6) + two, 140'000), text + more);
  EXPECT_THROW(gunzip(two, 139'999), Error);
  EXPECT_THROW(gunzip(two.substr(0, two.size() - 1), 140'000), Error);
  EXPECT_THROW(gunzip(two + "\x1f", 140'000), Error);  // one has begun
  EXPECT_THROW(gunzip(two + "\x1f\x8c", 140'000), Error);
  EXPECT_THROW(gunzip(two + text, 1'000'000), Error);
  std::string many, all;
  for (int k = 0; k < 300; ++k) {
    const std::string part = text_of(static_cast<std::size_t>(k));
    many += gzip(part, 6);
    all += part;
  }
  EXPECT_EQ(gunzip(many, all.size()), all);
}

// Tapes and block devices fill up their last block.
TEST(Gzip, ZerosBehindAMemberArePadding) {
  const std::string text = text_of(1000), zeros(511, '\0');
  EXPECT_EQ(gunzip(gzip(text, 6) + zeros, text.size()), text);
  EXPECT_EQ(gunzip(gzip(text, 6) + zeros + gzip(text, 6), 2 * text.size()), text + text);
  EXPECT_THROW(gunzip(gzip(text, 6) + zeros + "x", text.size()), Error);
  EXPECT_THROW(gunzip(zeros + gzip(text, 6), text.size()), Error);
  EXPECT_THROW(gunzip(zeros, 1000), Error);
}

TEST(Gzip, MembersAreUnpackedByTheByte) {
  const std::string text = text_of(1000);
  std::string unpacked;
  Gunzip gunzip;
  int ends = 0;
  for (const char c : gzip(text, 6) + std::string(3, '\0') + gzip(text, 6)) {
    gunzip.add({&c, 1}, [&unpacked](std::string_view piece) { unpacked += piece; });
    ends += gunzip.ended() ? 1 : 0;
  }
  EXPECT_EQ(ends, 5);  // two, and the padding
  EXPECT_EQ(unpacked, text + text);
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

TEST(Gzip, TextFilesHaveABeginning) {
  const tests::TemporaryFolder folder("beginning");
  const auto file = folder.path() / "text";
  const std::string text = text_of(50'000);
  for (const std::string& mark : {std::string(), std::string("\xEF\xBB\xBF")}) {
    for (const std::string& content : {mark + text, gzip(mark + text, 6)}) {
      write_file_atomically(file, content);
      EXPECT_EQ(text_beginning(file, 100), text.substr(0, 100));
      EXPECT_EQ(text_beginning(file, 1'000'000), text);
    }
  }
  write_file_atomically(file, "ab");
  EXPECT_EQ(text_beginning(file, 100), "ab");
  write_file_atomically(file, "");
  EXPECT_EQ(text_beginning(file, 100), "");
  EXPECT_THROW(text_beginning(folder.path() / "none", 100), FileError);
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

TEST(Gzip, AFileOfRepeatedBytesIsUnpackedToABoundAlone) {
  const tests::TemporaryFolder folder("gzip");
  const auto file = folder.path() / "blanks.json.gz";
  write_file_atomically(file, gzip(std::string(kAlwaysUnpacked, ' '), 9));
  EXPECT_EQ(read_text_file(file).size(), kAlwaysUnpacked);
  write_file_atomically(file, gzip(std::string(kAlwaysUnpacked + 1, ' '), 9));
  EXPECT_THAT([&] { read_text_file(file); },
              ThrowsMessage<FileError>(HasSubstr("more than 67108864 bytes")));
}

TEST(Gzip, TextFilesHaveANameBeforeTheirEnding) {
  EXPECT_EQ(name_before("some/a.json", ".json"), "a");
  EXPECT_EQ(name_before("some/a.b_c.json.gz", "_c.json"), "a.b");
  EXPECT_EQ(name_before(".json", ".json"), "");
  for (const char* other : {"a.jsonl", "a.json.gz.part1", "a.json/b", "a.gz", ""}) {
    EXPECT_EQ(name_before(other, ".json"), std::nullopt) << other;
  }
}

TEST(Gzip, TextFilesAreFoundPackedAndPlain) {
  const tests::TemporaryFolder made("found");
  const auto plain = made.path() / "a.json", packed = made.path() / "a.json.gz";
  EXPECT_EQ(find_text_file(plain), plain) << "neither is there";
  EXPECT_EQ(find_text_file(packed), packed);
  write_file_atomically(packed, gzip("packed", 6));
  EXPECT_EQ(find_text_file(plain), packed);
  EXPECT_EQ(read_text_file(plain), "packed");
  EXPECT_EQ(text_beginning(plain, 4), "pack");
  EXPECT_EQ(TextFile(plain).text(), "packed");
  write_file_atomically(plain, "plain");
  EXPECT_EQ(read_text_file(plain), "plain") << "the one that is named counts";
  EXPECT_EQ(read_text_file(packed), "packed");
  std::filesystem::remove(packed);
  EXPECT_EQ(read_text_file(packed), "plain");
}

}  // namespace EN_UNIT
}  // namespace enfilade
