#include "enfilade/draw/detail/svg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace enfilade::draw::detail {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(SvgEscape, MakesTextSafe) {
  EXPECT_EQ(escape("<a href=\"x\">'&'</a>"),
            "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
  EXPECT_EQ(escape("caf\u00e9 \u6771\u4eac \U0001F3E0\t\n"),
            "caf\u00e9 \u6771\u4eac \U0001F3E0\t\n");
}

TEST(SvgEscape, ReplacesWhatXmlForbids) {
  EXPECT_EQ(escape(std::string("a\0b\x1b", 4)), "a\uFFFDb\uFFFD");
  EXPECT_EQ(escape("\xff\x80"), "\uFFFD\uFFFD");
  EXPECT_EQ(escape("\xc3"), "\uFFFD") << "cut off";
  EXPECT_EQ(escape("\xc0\xaf"), "\uFFFD\uFFFD") << "longer than need be";
  EXPECT_EQ(escape("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD") << "half a surrogate pair";
  EXPECT_EQ(escape("\xef\xbf\xbf"), "\uFFFD\uFFFD\uFFFD") << "U+FFFF";
}

TEST(SvgNumber, IsShortAndNeverMinusZero) {
  EXPECT_EQ(number(12), "12");
  EXPECT_EQ(number(12.34), "12.3");
  EXPECT_EQ(number(-0.04), "0");
  EXPECT_EQ(pair({1.06, -2}), "1.1,-2");
}

TEST(SvgWrap, BreaksAtBlanks) {
  EXPECT_THAT(wrap("", 10, 100), IsEmpty());
  EXPECT_THAT(wrap("  \n", 10, 100), IsEmpty());
  const double width = text_width("walk out of", 10);
  EXPECT_THAT(wrap(" walk out of  the kitchen ", 10, width),
              ElementsAre("walk out of", "the kitchen"));
  EXPECT_THAT(wrap("unbreakable word", 10, 1), ElementsAre("unbreakable", "word"));
}

TEST(SvgTextWidth, CountsCharactersNotBytes) {
  EXPECT_EQ(text_width("\u00e9\u6771", 10), text_width("ab", 10));
}

}  // namespace
}  // namespace enfilade::draw::detail
