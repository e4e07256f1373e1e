#include "enfilade/core/detail/json_entries.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>

namespace enfilade::json {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Each entry as simdjson writes it; or what is thrown or reported.
std::vector<std::string> entries_of(std::string_view text) {
  std::vector<std::string> found;
  try {
    Faults faults("f");
    Entries entries(text, "f", 1U << 20U);
    if (!entries.is_list(faults)) return {to_string(faults.take().at(0))};
    while (entries.next()) {
      EXPECT_EQ(entries.index(), found.size());
      found.push_back(simdjson::minify(entries.element().value()));
    }
  } catch (const InvalidInput& error) {
    return {error.what()};
  }
  return found;
}

std::vector<std::string> whole(std::string_view text) {
  std::vector<std::string> found;
  try {
    const Document document = Document::parse(text, "f");
    Faults faults("f");
    const auto list = array(document.root(), Path(), faults);
    if (!list) return {to_string(faults.take().at(0))};
    for (const Element element : *list) found.push_back(simdjson::minify(element));
  } catch (const InvalidInput& error) {
    return {error.what()};
  }
  return found;
}

TEST(JsonEntries, AreTheOnesOfTheList) {
  EXPECT_THAT(entries_of(R"([{"a": [1, "]\""]}, 2 , "\\", [ ], null])"),
              ElementsAre(R"({"a":[1,"]\""]})", "2", R"("\\")", "[]", "null"));
  EXPECT_THAT(entries_of("\xEF\xBB\xBF [ 1 ]\n"), ElementsAre("1"));
  EXPECT_THAT(entries_of("[]"), ElementsAre());
}

TEST(JsonEntries, AcceptAndRefuseWhatAWholeParseDoes) {
  for (const std::string text : {"",
                                 " ",
                                 "[",
                                 "]",
                                 "[]]",
                                 "[],",
                                 "[1",
                                 "[1,",
                                 "[1,]",
                                 "[,1]",
                                 "[1,,2]",
                                 "[1 2]",
                                 "[1}",
                                 "{1]",
                                 "[{]",
                                 "[}]",
                                 "[{\"a\":1]",
                                 "[[1]",
                                 "[\"a]",
                                 "[\"a\\\"]",
                                 "[\"a\\\\\"]",
                                 "[NaN]",
                                 "[1, Infinity]",
                                 "[1e999]",
                                 "[01]",
                                 "[\"\xff\"]",
                                 "[1]\n2",
                                 "[1]\n",
                                 "[tru]",
                                 "[1:2]",
                                 "{\"a\": [1]}",
                                 "{\"a\": [1}",
                                 "\"text\"",
                                 "12",
                                 "nul",
                                 "null",
                                 "x",
                                 "[\n1,\n2,\n?\n]",
                                 "[{\"a\": [1,\n 2, ?]}]",
                                 "[\"\t\"]",
                                 "[1]\f",
                                 "\f[1]",
                                 "[1,\f2]"}) {
    EXPECT_EQ(entries_of(text), whole(text)) << text;
  }
  for (const std::size_t levels : {1022UL, 1023UL, 1024UL, 1025UL, 100'000UL}) {
    const std::string deep = std::string(levels, '[') + std::string(levels, ']');
    EXPECT_EQ(entries_of(deep), whole(deep)) << levels;
    EXPECT_EQ(entries_of(std::string(levels, '[')).size(), 1U) << levels;
  }
}

// A text without a byte to spare after it: what simdjson may look at is then a copy.
TEST(JsonEntries, AreReadWithoutLookingBehindTheText) {
  std::string text = "[";
  for (int k = 0; k < 100; ++k) text += (k > 0 ? "," : "") + std::to_string(k);
  text += "]";
  const std::vector<char> exact(text.begin(), text.end());
  const auto found = entries_of({exact.data(), exact.size()});
  ASSERT_EQ(found.size(), 100U);
  EXPECT_EQ(found.back(), "99");
}

TEST(JsonEntries, OneThatIsTooLargeIsPassedOver) {
  for (const std::string large :
       {R"({"large": "text"})", R"(["large", "}"])", R"({"a": {"b": "large"}})"}) {
    Faults faults("f");
    const std::string text = "[1, " + large + R"(, 3, {"b": {}}, {"a": 5}])";
    Entries entries(text, "f", 10);
    ASSERT_TRUE(entries.is_list(faults));
    std::vector<std::size_t> parsed;
    while (entries.next()) {
      if (entries.element()) parsed.push_back(entries.index());
      if (entries.index() == 1) {
        EXPECT_EQ(entries.bytes(), large.size());
      }
    }
    EXPECT_THAT(parsed, ElementsAre(0, 2, 3, 4)) << large;
    EXPECT_EQ(faults.errors(), 0U);
  }
  EXPECT_THAT(entries_of("[1, \"" + std::string(2U << 20U, 'x')),
              ElementsAre(HasSubstr("not-json")));
}

// Their ends are found in two ways.
TEST(JsonEntries, ObjectsWithAndWithoutObjectsInThem) {
  for (const char* text :
       {R"([{"a": 1}, {"b": [2]} ,{}])", R"([{"a": 1}, {"b": {"c": 2}}, {"d": 3}])",
        R"([{"a": "}"}, {"b": 2}])", R"([{"a": 1}, {"b": "},{"}, {"c": "\"}"}])",
        R"([{"a": 1} {"b": 2}])", R"([{"a": 1}}, {"b": 2}])", R"([{"a": 1}: 2])",
        R"([{"a": 1}, {"b": 2])", R"([{"a": {"b": 1}, {"c": 2}])", R"([{"a": 1},)",
        R"([{"a": {}}, {"b": [}]}])"}) {
    EXPECT_EQ(entries_of(text), whole(text)) << text;
  }
}

TEST(JsonEntries, ARootThatIsNoListIsNamedWithoutAParseOfIt) {
  std::string text = "{\"a\": [";
  for (int k = 0; k < 1000; ++k) text += "{},";
  text += "{}]}";
  EXPECT_THAT(entries_of(text), ElementsAre("error: f: $: object, not an array [not-an-array]"));
}

/// Each member as key and value, as simdjson writes them; or what is thrown or reported.
std::vector<std::string> members_of(std::string_view text) {
  std::vector<std::string> found;
  try {
    Faults faults("f");
    Members members(text, "f");
    if (!members.is_object(faults)) return {to_string(faults.take().at(0))};
    while (members.next()) {
      found.push_back(members.key() + ":" + simdjson::minify(members.element(1U << 20U).value()));
    }
  } catch (const InvalidInput& error) {
    return {error.what()};
  }
  return found;
}

std::vector<std::string> whole_object(std::string_view text) {
  std::vector<std::string> found;
  try {
    const Document document = Document::parse(text, "f");
    Faults faults("f");
    const auto object = json::object(document.root(), Path(), faults);
    if (!object) return {to_string(faults.take().at(0))};
    for (const auto member : *object) {
      found.push_back(std::string(member.key) + ":" + simdjson::minify(member.value));
    }
  } catch (const InvalidInput& error) {
    return {error.what()};
  }
  return found;
}

TEST(JsonMembers, AreTheOnesOfTheObject) {
  EXPECT_THAT(members_of(R"({"a": [1, "}\""], "b\"\u0041" : {"c": 2} , "a": [ ], "": null})"),
              ElementsAre(R"(a:[1,"}\""])", R"(b"A:{"c":2})", "a:[]", ":null"));
  EXPECT_THAT(members_of("\xEF\xBB\xBF { \"a\": 1 }\n"), ElementsAre("a:1"));
  EXPECT_THAT(members_of("{}"), ElementsAre());
}

TEST(JsonMembers, AcceptAndRefuseWhatAWholeParseDoes) {
  for (const std::string text : {"",
                                 " ",
                                 "{",
                                 "}",
                                 "{}}",
                                 "{},",
                                 "{\"a\"",
                                 "{\"a\"}",
                                 "{\"a\":",
                                 "{\"a\":}",
                                 "{\"a\":,}",
                                 "{\"a\":1",
                                 "{\"a\":1,",
                                 "{\"a\":1,}",
                                 "{,\"a\":1}",
                                 "{\"a\":1,,\"b\":2}",
                                 "{\"a\":1 \"b\":2}",
                                 "{\"a\":1]",
                                 "{\"a\":1:2}",
                                 "{\"a\" 1}",
                                 "{a:1}",
                                 "{1:1}",
                                 "{\"a:1}",
                                 "{\"a\\\":1}",
                                 "{\"a\\x\":1}",
                                 "{\"\xff\":1}",
                                 "{\"a\":[1}",
                                 "{\"a\":{]}",
                                 "{\"a\":NaN}",
                                 "{\"a\":1e999}",
                                 "{\"a\":01}",
                                 "{\"a\":tru}",
                                 "{\"a\":1}\n2",
                                 "{\"a\":1}\n",
                                 "\"text\"",
                                 "12",
                                 "nul",
                                 "null",
                                 "x",
                                 "{\n\"a\":1,\n\"b\":2,\n?\n}",
                                 "{\"a\": [{\"b\": [1,\n 2, ?]}]}"}) {
    EXPECT_EQ(members_of(text), whole_object(text)) << text;
  }
  EXPECT_THAT(members_of("[1, 2]"), ElementsAre(HasSubstr("$: array, not an object")));
  EXPECT_THAT(members_of("[1, 2"), ElementsAre(HasSubstr("not-json")));
}

TEST(JsonMembers, LeaveLargeValuesToTheirReaders) {
  const std::string text = R"({"list": [1, 2, 3], "b": [4, ?]})";
  Members members(text, "f");
  Faults faults("f");
  ASSERT_TRUE(members.is_object(faults));
  ASSERT_TRUE(members.next());
  EXPECT_EQ(members.value(), "[1, 2, 3]");
  EXPECT_FALSE(members.element(8).has_value());
  EXPECT_TRUE(members.element(9).has_value());
  ASSERT_TRUE(members.next());
  EXPECT_EQ(members.value(), "[4, ?]");  // its reader will find the fault
  EXPECT_FALSE(members.next());
  EXPECT_THROW(members.check_whole(), InvalidInput);
}

}  // namespace EN_UNIT
}  // namespace enfilade::json
