#include "enfilade/draw/markup.h"

#include <gtest/gtest.h>

namespace enfilade::draw {
namespace EN_UNIT {

TEST(Escape, MakesTextSafe) {
  EXPECT_EQ(escape("<a href=\"x\">'&'</a>"),
            "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
  EXPECT_EQ(escape("caf\u00e9 \u6771\u4eac \U0001F3E0\t\n"),
            "caf\u00e9 \u6771\u4eac \U0001F3E0\t\n");
}

TEST(Escape, ReplacesWhatXmlForbids) {
  EXPECT_EQ(escape(std::string("a\0b\x1b", 4)), "a\uFFFDb\uFFFD");
  EXPECT_EQ(escape("\xff\x80"), "\uFFFD\uFFFD");
  EXPECT_EQ(escape("\xc3"), "\uFFFD") << "cut off";
  EXPECT_EQ(escape("\xc0\xaf"), "\uFFFD\uFFFD") << "longer than need be";
  EXPECT_EQ(escape("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD") << "half a surrogate pair";
  EXPECT_EQ(escape("\xef\xbf\xbf"), "\uFFFD\uFFFD\uFFFD") << "U+FFFF";
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
