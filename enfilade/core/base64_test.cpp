#include "enfilade/core/base64.h"

#include <gtest/gtest.h>
#include <vector>

namespace enfilade {
namespace EN_UNIT {

std::string encoded(std::string_view bytes) {
  std::string text;
  append_base64(std::as_bytes(std::span(bytes)), text);
  return text;
}

std::string decoded(std::string_view text) {
  const auto size = base64_bytes(text);
  if (!size) return "no whole groups";
  std::string bytes(*size, '\0');
  const std::size_t fault = decode_base64(text, std::as_writable_bytes(std::span(bytes)));
  return fault == std::string_view::npos ? bytes : "fault at " + std::to_string(fault);
}

// The test vectors of RFC 4648, section 10.
TEST(Base64, IsAsTheStandardSays) {
  const std::vector<std::pair<std::string, std::string>> vectors{{"", ""},
                                                                 {"f", "Zg=="},
                                                                 {"fo", "Zm8="},
                                                                 {"foo", "Zm9v"},
                                                                 {"foob", "Zm9vYg=="},
                                                                 {"fooba", "Zm9vYmE="},
                                                                 {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : vectors) {
    EXPECT_EQ(encoded(bytes), text);
    EXPECT_EQ(decoded(text), bytes);
  }
}

TEST(Base64, AnyBytesComeBack) {
  std::string bytes;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(decoded(encoded(bytes)), bytes);
    bytes += static_cast<char>(i * 37 + i / 7);
  }
}

TEST(Base64, SaysWhereItIsBroken) {
  EXPECT_EQ(decoded("Zm9"), "no whole groups");
  EXPECT_EQ(decoded("Zm9vZ-9v"), "fault at 5");
  EXPECT_EQ(decoded("Zg==Zm9v"), "fault at 2") << "padding is at the end only";
  EXPECT_EQ(decoded("Z==="), "fault at 1");
  EXPECT_EQ(decoded("===="), "fault at 0");
  EXPECT_EQ(decoded("Zm9v\n"), "no whole groups");
  EXPECT_EQ(decoded("Zm\xffv"), "fault at 2");
}

}  // namespace EN_UNIT
}  // namespace enfilade
