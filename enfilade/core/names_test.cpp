#include "enfilade/core/names.h"

#include <gtest/gtest.h>
#include <string>
#include <string_view>

#include "enfilade/core/detail/json.h"

namespace enfilade {
namespace EN_UNIT {

using namespace std::string_literals;

TEST(Names, IdsOfTheFieldsFilesAreIds) {
  for (const char* id :
       {"17DRP5sb8fy", "00800-TEEsavR23oF", "10c252c90fa24ef3b698c6f54d984c5c", "000007", "3-0_0",
        "4634_215", "00000-kfPV7w3FaU5_12_0", "home0004", "_", "a.b", "7"}) {
    EXPECT_TRUE(is_id(id)) << id;
    EXPECT_EQ(fault_of_id(id), "") << id;
  }
  EXPECT_TRUE(is_id(std::string(kLongestId, 'a')));
}

TEST(Names, PathsOptionsAndControlCharactersAreNot) {
  for (const std::string& id :
       {""s, "."s, ".."s, "../x"s, "/etc/passwd"s, "a/b"s, "a\\b"s, "-o"s, ".hidden"s, "a b"s,
        "a\nb"s, "a\0b"s, "a\x1b[2J"s, "\xc3\xbc"s, "a\xff"s, "a:b"s, std::string(101, 'a')}) {
    EXPECT_FALSE(is_id(id)) << id;
    EXPECT_NE(fault_of_id(id), "") << id;
  }
  EXPECT_TRUE(is_id(std::string(101, 'a'), kLongestInstructionId));
}

TEST(Names, FaultNamesTheBeginningOfALongValue) {
  EXPECT_EQ(fault_of_id("../x"),
            "\"../x\" is not an id: 1 to 100 of the characters A-Z a-z 0-9 _ - . are allowed, the "
            "first not - or .");
  const std::string fault = fault_of_id(std::string(50'000'000, 'a'));
  EXPECT_LT(fault.size(), 200U);
  EXPECT_NE(fault.find("(50000000 bytes)"), std::string::npos) << fault;
}

TEST(Names, OfFilesStayInTheirFolder) {
  for (const std::string& name : {"a.json"s, "living room.obj"s,
                                  "K\xc3\xbc"
                                  "che.jpg"s,
                                  "a..b"s, "-"s, std::string(255, 'a')}) {
    EXPECT_TRUE(is_file_name(name)) << name;
  }
  for (const std::string& name : {""s, "."s, ".."s, "a/b"s, "/a"s, "a\\b"s, "a\0b"s, "a\nb"s,
                                  "\x7f"s, ".a"s, std::string(256, 'a')}) {
    EXPECT_FALSE(is_file_name(name)) << name;
  }
}

TEST(Names, QuotedTextsAreShortAndEscaped) {
  EXPECT_EQ(quote("a\"b\n"), R"("a\"b\n")");
  EXPECT_EQ(quote(std::string(41, 'a')), '"' + std::string(40, 'a') + "\"... (41 bytes)");
  // The character at byte 40 is not cut: two bytes each, one byte before.
  std::string umlauts = "a";
  for (int i = 0; i < 40; ++i) umlauts += "\xc3\xbc";
  EXPECT_EQ(quote(umlauts).substr(0, 2 + 39), '"' + umlauts.substr(0, 39) + '"');
}

TEST(Names, PrintableTextsDoNotSteerATerminal) {
  EXPECT_EQ(printable("a\tb\nK\xc3\xbc"
                      "che \xf0\x9f\x8f\xa0"),
            "a\tb\nK\xc3\xbc"
            "che \xf0\x9f\x8f\xa0");
  EXPECT_EQ(printable("\x1b[2Jx\r\x7f"), "\\x1b[2Jx\\x0d\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\u{9b}31m");
  EXPECT_EQ(printable("\xe2\x80\xae"
                      "abc\xe2\x81\xa9"),
            "\\u{202e}abc\\u{2069}");
  EXPECT_EQ(printable("a\xff\xc3"), "a\\xff\\xc3");
}

TEST(Names, JsonIdsAreCheckedWhereTheyAreRead) {
  const json::Document document = json::Document::parse(R"(["a1", "../x", 7, ""])", "f.json");
  json::Faults faults("f.json");
  std::string read;
  std::size_t i = 0;
  for (const json::Element one : document.root().get_array().value()) {
    read += json::id(one, json::Path(json::Path(), i++), faults).value_or("-");
  }
  EXPECT_EQ(read, "a1---");
  const auto found = faults.take();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].code, "bad-id");
  EXPECT_EQ(found[0].where, "$[1]");
  EXPECT_EQ(found[1].code, "not-a-string");
  EXPECT_EQ(found[2].message, "an empty id");
}

TEST(UnderscoreBetweenIds, IsTheLastThatLeavesTwo) {
  EXPECT_EQ(underscore_between_ids("one_v0"), 3U);
  EXPECT_EQ(underscore_between_ids("a_b_c"), 3U);
  EXPECT_EQ(underscore_between_ids("a_b_-1"), 1U) << "-1 is no id";
  EXPECT_EQ(underscore_between_ids("a_b_"), 1U);
  EXPECT_EQ(underscore_between_ids(std::string(100, 's') + "_" + std::string(60, 'v') + "_x"),
            100U);
  EXPECT_EQ(underscore_between_ids("one_../x"), 3U) << "none is left";
  EXPECT_EQ(underscore_between_ids("_v"), 0U);
  EXPECT_EQ(underscore_between_ids("v"), std::string_view::npos);
}

}  // namespace EN_UNIT
}  // namespace enfilade
