#include "enfilade/core/written_lists.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

using namespace std::string_literals;

TEST(PlainText, HasNoByteOrderMark) {
  EXPECT_EQ(plain_text("one\n"), "one\n");
  EXPECT_EQ(plain_text("\xEF\xBB\xBFone\n"), "one\n");
  EXPECT_EQ(plain_text("\xEF\xBB\xBF"), "");
  EXPECT_EQ(plain_text("one\xEF\xBB\xBF"), "one\xEF\xBB\xBF");  // only the first is a mark
}

TEST(PlainText, OfUtf16WithAMarkIsUtf8) {
  EXPECT_EQ(plain_text("\xFF\xFEo\0n\0e\0\n\0"s), "one\n");
  EXPECT_EQ(plain_text("\xFE\xFF\0o\0n\0e"s), "one");
  // u umlaut, the euro, a character beyond 16 bits.
  EXPECT_EQ(plain_text("\xFF\xFE\xFC\0\xAC\x20\x3D\xD8\x00\xDE"s), "\u00FC\u20AC\U0001F600");
  EXPECT_EQ(plain_text("\xFE\xFF\x00\xFC\x20\xAC\xD8\x3D\xDE\x00"s), "\u00FC\u20AC\U0001F600");
}

TEST(PlainText, OfDamagedUtf16HasReplacements) {
  EXPECT_EQ(plain_text("\xFF\xFEo\0n"s), "o\uFFFD");
  EXPECT_EQ(plain_text("\xFF\xFE\x3D\xD8"s), "\uFFFD");                // half a character
  EXPECT_EQ(plain_text("\xFF\xFE\x3D\xD8o\0"s), "\uFFFDo");            // its first half alone
  EXPECT_EQ(plain_text("\xFF\xFE\x00\xDE\x3D\xD8"s), "\uFFFD\uFFFD");  // in the wrong order
}

TEST(PlainText, IsReadPackedOrPlain) {
  const tests::TemporaryFolder folder("written_lists");
  write_file_atomically(folder.path() / "list.txt", gzip("\xEF\xBB\xBFone", 6));
  EXPECT_EQ(read_plain_text(folder.path() / "list.txt"), "one");
}

TEST(WrittenLists, BlanksAtTheEndsOfEntriesDoNotCount) {
  EXPECT_EQ(trimmed(" \t one two\r\n"), "one two");
  EXPECT_EQ(trimmed("\u00A0 one \u00A0"), "one");
  EXPECT_EQ(trimmed(" \u00A0\t"), "");
  EXPECT_EQ(trimmed(""), "");
}

TEST(WrittenLists, LinesEndAsOnAnySystem) {
  for (const char* end : {"\n", "\r\n", "\r"}) {
    const std::string text = "one"s + end + end + " # no entry" + end + " two " + end + "three";
    const auto lines = list_lines(text);
    ASSERT_EQ(lines.size(), 3U) << text;
    EXPECT_EQ(lines[0].text, "one");
    EXPECT_EQ(lines[0].number, 1U);
    EXPECT_EQ(lines[1].text, "two");
    EXPECT_EQ(lines[1].number, 4U);
    EXPECT_EQ(lines[2].text, "three");
    EXPECT_EQ(lines[2].number, 5U);
  }
  EXPECT_EQ(list_lines("#1\n#2", HashLines::kEntries).size(), 2U);
  EXPECT_TRUE(list_lines(" \n\r\n# nothing\n").empty());
}

TEST(WrittenLists, AllLinesOfATextAreAsTheyStand) {
  EXPECT_THAT(all_lines(" a \r\n\r\n#b\n\nc"), ElementsAre(" a ", "", "#b", "", "c"));
  EXPECT_THAT(all_lines("a\n"), ElementsAre("a"));
  EXPECT_THAT(all_lines("\n"), ElementsAre(""));
  EXPECT_THAT(all_lines(""), IsEmpty());
}

}  // namespace EN_UNIT
}  // namespace enfilade
