#include "enfilade/service/http/messages.h"

#include <gmock/gmock.h>

namespace enfilade::service::http {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

TEST(Query, IsReadAsBrowsersWriteIt) {
  EXPECT_THAT(parse_query("/x"), IsEmpty());
  EXPECT_THAT(parse_query("/x?"), IsEmpty());
  EXPECT_THAT(parse_query("/x?a=1&b=two"), ElementsAre(Pair("a", "1"), Pair("b", "two")));
  EXPECT_THAT(parse_query("/x?m=a+b%20c%2b"), ElementsAre(Pair("m", "a b c+")));
  EXPECT_THAT(parse_query("/x?%61=%C3%A9%00"),
              ElementsAre(Pair("a", std::string("\xC3\xA9\0", 3))));
}

TEST(Query, KeepsWhatIsUnusual) {
  EXPECT_THAT(parse_query("/x?link=https://example.org/?a=1"),
              ElementsAre(Pair("link", "https://example.org/?a=1")));
  EXPECT_THAT(parse_query("/x?a=1&&a=2&b&=c"),
              ElementsAre(Pair("", "c"), Pair("a", "1"), Pair("b", "")));
  EXPECT_THAT(parse_query("/x?a=100%&b=%4&c=%g1&d=%+1&e=%-1"),
              ElementsAre(Pair("a", "100%"), Pair("b", "%4"), Pair("c", "%g1"), Pair("d", "% 1"),
                          Pair("e", "%-1")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service::http
