#include "enfilade/arena/detail/secrets.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "tests/support/base64_text.h"

namespace enfilade::arena::detail {
namespace EN_UNIT {

using tests::base64;

TEST(Secrets, AreFoundHoweverTheyAreWritten) {
  const std::string key = "sk-\"a/b\\c+12";
  const Secrets secrets({key});
  const std::string rows[] = {
      key,
      R"(sk-\"a\/b\\c+12)",
      R"(\u0073\u006b-\u0022a\u002Fb\u005cc\u002b12)",
      R"(sk-\\\"a\\\/b\\\\c+12)",  // JSON in JSON
      "sk-%22a%2Fb%5Cc%2B12",
      "%73%6b%2d%22%61%2f%62%5c%63%2b%31%32",
  };
  for (const std::string& row : rows) {
    EXPECT_EQ(secrets.hide("<" + row + "> " + row), "<(key)> (key)") << row;
  }
  for (const char* before : {"", "u", "me"}) {
    for (const char* after : {"", "!", "?!", " and so on"}) {
      std::string text = base64(before + std::string(":") + key + after);
      EXPECT_NE(secrets.hide(text), text) << before << after;
      for (char& c : text) c = c == '+' ? '-' : c == '/' ? '_' : c;  // of addresses
      EXPECT_NE(secrets.hide(text), text) << before << after;
    }
  }
}

TEST(Secrets, AnyKeyIsReplacedInOnePass) {
  struct Row {
    std::vector<std::string> keys;
    std::string text, shown;
  };
  const Row rows[] = {
      {{"key"}, "Incorrect API key: keys", "Incorrect API (key): keys"},
      {{"e"}, "the letter e, e_e and \"e\"", "the letter (key), e_e and \"(key)\""},
      {{"("}, "(a)", "(a)"},
      {{"("}, "( a)(", "(key) a)(key)"},
      {{"(key)(key)"}, "(key)(key)(key)", "(key)(key)"},
      {{"aaaaaaaa"}, "aaaaaaaaaaaaaaaaa", "(key)(key)a"},
      {{"sk-12345", "sk-12345678"}, "sk-12345678 sk-12345", "(key) (key)"},  // the longest
      {{"", "sk-12345"}, "sk-1234 \\", "sk-1234 \\"},
      {{"secret", "a\xc3\xb6pfel88"}, "a\xc3\xb6pfel88 secrets", "(key) secrets"},
      {{"token"}, "dG9rZW4= dG9rZW4", "(key)= (key)"},
      {{"\\\\\\key1234"}, "\\\\key1234", "(key)"},
      {{}, "anything", "anything"},
  };
  for (const Row& row : rows) EXPECT_EQ(Secrets(row.keys).hide(row.text), row.shown) << row.text;
}

TEST(Secrets, AreFoundInNamesTextsAndNumbersOfJson) {
  const Secrets secrets({"sk-secret1", "1234567890"});
  const std::string without = R"({"a": [1.50, {"b": null}]})";
  EXPECT_EQ(secrets.hide_in_body(without), without) << "as it came";
  EXPECT_EQ(secrets.hide_in_body(R"({"sk-\u0073ecret1": {"a": ["\u0073k-secret1", 1234567890]}})"),
            R"-({"(key)":{"a":["(key)","(key)"]}})-");
  EXPECT_EQ(secrets.hide_in_body(R"({"arguments": "{\"place\": \"sk-\\u0073ecret1\"}"})"),
            R"-({"arguments":"{\"place\": \"(key)\"}"})-");
  EXPECT_EQ(secrets.hide_in_body(R"({"content": [{"text": "sk-sec"}, {"text": "ret1!"}, "x"]})"),
            R"-({"content":"(key)!x"})-")
      << "split over the parts of a content";
  EXPECT_EQ(secrets.hide_in_body(R"({"a": "sk-secret1", "a": "x"})"), R"({"a":"x"})")
      << "names that repeat";
  EXPECT_EQ(secrets.hide_in_body("<b>sk-secret1</b>"), "<b>(key)</b>");
  EXPECT_EQ(secrets.hide_in_body("\"sk-secret1"), "\"(key)");
}

TEST(Secrets, LongTextsOfEscapesTakeLittleTime) {
  const Secrets secrets({"sk-secret1", "\\\\\\\\secret", "%%%%%%%%"});
  const auto begin = std::chrono::steady_clock::now();
  for (const char* part : {"\\", "%", "sk-secre", "\\u0073\\", "%2"}) {
    std::string text;
    while (text.size() < (256U << 10U)) text += part;
    secrets.hide(text);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena::detail
