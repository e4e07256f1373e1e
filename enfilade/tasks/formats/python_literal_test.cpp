#include "enfilade/tasks/formats/python_literal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace enfilade::tasks::formats {
namespace EN_UNIT {

using ::testing::HasSubstr;

// "byte: message", or nothing.
std::string fault_of(const std::string& text) {
  WordLists lists;
  const auto fault = read_word_lists(text, lists);
  return fault ? std::to_string(fault->byte) + ": " + fault->message : "";
}

WordLists read(const std::string& text) {
  WordLists lists;
  EXPECT_EQ(fault_of(text), "") << text;
  read_word_lists(text, lists);
  return lists;
}

TEST(PythonLiteral, IsListsOfListsOfListsOfWords) {
  EXPECT_EQ(read("[[['walk', 'on'], ['stop']], [[\"it's\"]]]"),
            (WordLists{{{"walk", "on"}, {"stop"}}, {{"it's"}}}));
  EXPECT_EQ(read("[]"), WordLists());
  EXPECT_EQ(read("[[], [[]], [['']]]"), (WordLists{{}, {{}}, {{""}}}));
}

TEST(PythonLiteral, MayHaveBlanksAndATrailingComma) {
  EXPECT_EQ(read(" \n[\t[ [ 'a' ,\r\n'b' , ] , ] , ]  "), (WordLists{{{"a", "b"}}}));
}

TEST(PythonLiteral, HasPythonsEscapes) {
  EXPECT_EQ(read(R"([[['\'', '\"', "\"'", '\\', '\n\r\t']]])"),
            (WordLists{{{"'", "\"", "\"'", "\\", "\n\r\t"}}}));
  EXPECT_EQ(read(R"([[['\x41\xe9', '\u00e9\u20ac', '\U0001f600']]])"),
            (WordLists{{{"A\xC3\xA9", "\xC3\xA9\xE2\x82\xAC", "\xF0\x9F\x98\x80"}}}));
  EXPECT_EQ(read("[[['Stra\xC3\x9F"
                 "e']]]"),
            (WordLists{{{"Stra\xC3\x9F"
                         "e"}}}));
}

TEST(PythonLiteral, IsRefusedWithThePlaceAndWhatIsExpected) {
  const struct {
    const char* name;
    std::string text;
    std::string fault;
  } rows[]{
      {"empty", "", "0: the text ends; a list, which begins with ["},
      {"no list", "'walk'", "0: \"'walk'\"; a list, which begins with ["},
      {"a tuple", "(['a'],)", "0: \"(['a'],)\"; a list"},
      {"words at the first level", "['walk']", "1: \"'walk']\"; the list of an instruction or ]"},
      {"words at the second level", "[['walk']]", "2: \"'walk']]\"; the list of a piece or ]"},
      {"a list of words too deep", "[[[['walk']]]]", "3: \"['walk']]]]\"; a word in quotes or ]"},
      {"a number", "[[[1]]]", "3: \"1]]]\"; a word in quotes or ]"},
      {"a name", "[[[None]]]", "3: \"None]]]\"; a word in quotes"},
      {"a prefix", "[[[u'a']]]", "3: \"u'a']]]\"; a word in quotes"},
      {"side by side", "[[['a' 'b']]]", "7: \"'b']]]\"; , or ]"},
      {"no comma", "[[['a']] [['b']]]", "9: \"[['b']]]\"; , or ]"},
      {"two commas", "[[['a',, 'b']]]", "7: \", 'b']]]\"; a word in quotes or ]"},
      {"a comma alone", "[,]", "1: \",]\"; the list of an instruction or ]"},
      {"cut after a bracket", "[[['a']", "7: the text ends; , or ]"},
      {"cut in a string", "[[['a",
       "5: the text ends; ', which ends the string that begins at byte 3"},
      {"the other quote", "[[['a\"]]]", "9: the text ends; ', which ends"},
      {"cut in an escape", "[[['\\", "4: \"\\\\\"; one of the escapes"},
      {"an unknown escape", "[[['\\a']]]", R"(4: "\\a']]]"; one of the escapes)"},
      {"a short code", "[[['\\x4']]]", R"(4: "\\x4']]]"; 2 hexadecimal digits)"},
      {"a signed code", "[[['\\u-123']]]", R"(4: "\\u-123']]]"; 4 hexadecimal digits)"},
      {"a surrogate", "[[['\\ud800']]]", R"(4: "\\ud800']]]"; the code of a character)"},
      {"too large a code", "[[['\\U00110000']]]", "the code of a character: up to 10ffff"},
      {"a line break", "[[['a\nb']]]", R"(5: "\nb']]]"; an escape such as \n)"},
      {"a zero byte", std::string("[[['\0']]]", 9), "an escape such as \\n instead of"},
      {"something after", "[[]] x", "5: \"x\"; the end of the text"},
      {"two lists", "[][]", "2: \"[]\"; the end of the text"},
  };
  for (const auto& row : rows) EXPECT_THAT(fault_of(row.text), HasSubstr(row.fault)) << row.name;
}

TEST(PythonLiteral, TakesNoStackForDeepNesting) {
  EXPECT_THAT(fault_of(std::string(1 << 20, '[')), HasSubstr("3: \"[[[[[[[[[[[[\"; a word"));
}

TEST(PythonLiteral, IsWrittenAsPythonDoes) {
  EXPECT_EQ(write_word_lists({{{"walk", "on"}, {}}, {}, {{"it's", "\"so\"", "\"it's\""}}}),
            R"([[['walk', 'on'], []], [], [["it's", '"so"', '"it\'s"']]])");
  EXPECT_EQ(write_word_lists({{{"a\\b\n\r\t\x01\x7f"}}}), R"([[['a\\b\n\r\t\x01\x7f']]])");
  EXPECT_EQ(write_word_lists({}), "[]");
}

TEST(PythonLiteral, IsReadBackEqual) {
  std::string all;
  for (int c = 0; c < 0x80; ++c) all += static_cast<char>(c);
  const WordLists lists{{}, {{}}, {{all, "\xC3\x9F\xF0\x9F\x98\x80", ""}, {"'"}}, {{"\""}}};
  EXPECT_EQ(read(write_word_lists(lists)), lists);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks::formats
