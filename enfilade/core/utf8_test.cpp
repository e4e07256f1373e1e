#include "enfilade/core/utf8.h"

#include <gtest/gtest.h>

#include <array>

namespace enfilade {
namespace EN_UNIT {

TEST(Utf8Length, IsOneToFourBytesAtTheBordersOfTheForms) {
  EXPECT_EQ(utf8_length(std::string_view("\0", 1)), 1U);
  EXPECT_EQ(utf8_length("\x7F"), 1U);
  EXPECT_EQ(utf8_length("\xC2\x80"), 2U);
  EXPECT_EQ(utf8_length("\xDF\xBF"), 2U);
  EXPECT_EQ(utf8_length("\xE0\xA0\x80"), 3U);
  EXPECT_EQ(utf8_length("\xEF\xBF\xBF"), 3U);
  EXPECT_EQ(utf8_length("\xF0\x90\x80\x80"), 4U);
  EXPECT_EQ(utf8_length("\xF4\x8F\xBF\xBFmore"), 4U);
}

TEST(Utf8Length, IsNoneForWhatIsNotWellFormed) {
  EXPECT_EQ(utf8_length(""), 0U);
  EXPECT_EQ(utf8_length("\x80"), 0U);              // a later byte first
  EXPECT_EQ(utf8_length("\xC3"), 0U);              // cut short
  EXPECT_EQ(utf8_length("\xC3("), 0U);             // another character inside
  EXPECT_EQ(utf8_length("\xC0\xAF"), 0U);          // overlong
  EXPECT_EQ(utf8_length("\xE0\x9F\xBF"), 0U);      // overlong
  EXPECT_EQ(utf8_length("\xF0\x8F\xBF\xBF"), 0U);  // overlong
  EXPECT_EQ(utf8_length("\xED\xA0\x80"), 0U);      // a surrogate
  EXPECT_EQ(utf8_length("\xF4\x90\x80\x80"), 0U);  // above U+10FFFF
  EXPECT_EQ(utf8_length("\xFF"), 0U);
}

TEST(Utf8, HasAMarkAtItsBeginningOnly) {
  EXPECT_EQ(without_byte_order_mark("\uFEFFone"), "one");
  EXPECT_EQ(without_byte_order_mark("\uFEFF\uFEFF"), "\uFEFF") << "one mark";
  for (const std::string_view text : {"", "one", "one\uFEFF", "\xEF\xBB"}) {
    EXPECT_EQ(without_byte_order_mark(text), text);
  }
}

TEST(AppendUtf8, IsUndoneByTheLengths) {
  std::string text;
  for (const std::uint32_t code : {0x41U, 0x7ffU, 0xffffU, 0x10ffffU}) append_utf8(code, text);
  EXPECT_EQ(text, "A\xDF\xBF\xEF\xBF\xBF\xF4\x8F\xBF\xBF");
}

TEST(Utf8, PrefixesEndBetweenCharacters) {
  const std::string_view text = "a\u00e9\u20ac";  // of 1, 2 and 3 bytes
  constexpr std::array<std::size_t, 8> kLengths{0, 1, 1, 3, 3, 3, 6, 6};
  for (std::size_t most = 0; most < kLengths.size(); ++most) {
    EXPECT_EQ(utf8_prefix(text, most).size(), kLengths[most]) << most;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade
