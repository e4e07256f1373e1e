#include "enfilade/core/detail/json_entries.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace enfilade::json {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

std::vector<std::int64_t> numbers_of(const std::string& text, std::size_t most_bytes = 100) {
  Records records(text, "a.jsonl", most_bytes);
  std::vector<std::int64_t> found;
  while (records.next()) {
    EXPECT_EQ(records.index(), found.size());
    found.push_back(records.element() ? records.element()->at_key("n").get_int64().value_unsafe()
                                      : -static_cast<std::int64_t>(records.bytes()));
  }
  return found;
}

TEST(JsonRecords, AListAndLinesGiveTheSame) {
  EXPECT_THAT(numbers_of("[{\"n\": 1}, {\"n\": 2},\n {\"n\": 3}]"), ElementsAre(1, 2, 3));
  EXPECT_THAT(numbers_of("{\"n\": 1}\n\n{\"n\": 2}\r\n{\"n\": 3}"), ElementsAre(1, 2, 3));
  EXPECT_THAT(numbers_of("\xEF\xBB\xBF{\"n\": 1}\n"), ElementsAre(1));
  EXPECT_THAT(numbers_of("\n [{\"n\": 7}]\n"), ElementsAre(7));
  EXPECT_THAT(numbers_of("[]"), IsEmpty());
  EXPECT_THAT(numbers_of(" \n\n"), IsEmpty());
}

TEST(JsonRecords, ALineThatIsNotJsonIsNamed) {
  EXPECT_THAT([] { numbers_of("{\"n\": 1}\n\n{\"n\": }\n"); },
              ThrowsMessage<InvalidInput>(HasSubstr("a.jsonl:3")));
  EXPECT_THAT([] { numbers_of("[{\"n\": 1}, {\"n\": }]"); },
              ThrowsMessage<InvalidInput>(HasSubstr("a.jsonl")));
}

TEST(JsonRecords, OneThatIsTooLargeIsCountedAndNotParsed) {
  EXPECT_THAT(numbers_of("{\"n\": 1}\n{\"n\": 123456}\n{\"n\": 2}\n", 9), ElementsAre(1, -13, 2));
}

// However the text is cut, the records and their places are the same.
TEST(JsonRecords, PartsHaveTheRecordsOfTheWhole) {
  const std::string text =
      "\xEF\xBB\xBF{\"n\": 1}\n\n{\"n\": 22}\r\n \t\n{\"n\": 3}\n[4]\n{\"n\": 5}";
  for (std::size_t bytes = 1; bytes < 60; ++bytes) {
    const Parts parts = split_records(text, bytes);
    ASSERT_TRUE(parts.is_lines);
    std::vector<std::size_t> places;
    std::string joined;
    for (std::size_t k = 0; k < parts.texts.size(); ++k) {
      joined += parts.texts[k];
      Records records(parts.texts[k], "a.jsonl", 1000, parts.begins[k]);
      while (records.next()) places.push_back(records.index());
    }
    EXPECT_EQ(joined, text.substr(3));
    EXPECT_THAT(places, ElementsAre(0, 1, 2, 3, 4)) << bytes;
  }
  EXPECT_EQ(split_records("[1, 2]", 2).texts.size(), 1U);
  EXPECT_FALSE(split_records("[1, 2]", 2).is_lines);
}

TEST(JsonRecords, AFaultOfAPartNamesTheLineOfTheFile) {
  const Parts parts = split_records("{\"n\": 1}\n\n{\"n\": }\n", 1);
  EXPECT_THAT(
      [&] {
        for (std::size_t k = 0; k < parts.texts.size(); ++k) {
          Records records(parts.texts[k], "a.jsonl", 1000, parts.begins[k]);
          while (records.next()) {
          }
        }
      },
      ThrowsMessage<InvalidInput>(HasSubstr("a.jsonl:3")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::json
