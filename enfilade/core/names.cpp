#include "enfilade/core/names.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstdint>

#include "enfilade/core/utf8.h"

namespace enfilade {
namespace {

constexpr std::size_t kLongestFileName = 255;  // of Linux's file systems

bool is_control(unsigned char c) noexcept { return c < 0x20 || c == 0x7f; }

// A table, as branches on random hexadecimal digits are mispredicted: annotations have 150,000 ids.
constexpr auto kOfIds = [] {
  std::array<bool, 256> table{};
  for (const char c :
       std::string_view("0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_-.")) {
    table[static_cast<unsigned char>(c)] = true;
  }
  return table;
}();

bool may_stand_in_id(char c) noexcept { return kOfIds[static_cast<unsigned char>(c)]; }

// The code point of a well-formed character.
std::uint32_t code_of(std::string_view character) {
  const auto first = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return first;
  // The first byte of a character of n bytes has its 7 - n lowest bits.
  std::uint32_t code = first & ((1U << (7 - character.size())) - 1);
  for (const char c : character.substr(1)) {
    code = (code << 6U) | (static_cast<unsigned char>(c) & 0x3fU);
  }
  return code;
}

// U+0080 to U+009F control terminals too; the others turn the direction of what follows.
bool is_unsafe(std::uint32_t code) noexcept {
  return (code < 0x20 && code != '\n' && code != '\t') || (code >= 0x7f && code < 0xa0) ||
         code == 0x061c || code == 0x200e || code == 0x200f || (code >= 0x202a && code <= 0x202e) ||
         (code >= 0x2066 && code <= 0x2069);
}

}  // namespace

bool is_id(std::string_view text, std::size_t most) noexcept {
  return !text.empty() && text.size() <= most && text[0] != '.' && text[0] != '-' &&
         std::ranges::all_of(text, may_stand_in_id);
}

std::string fault_of_id(std::string_view text, std::size_t most) {
  if (text.empty()) return "an empty id";
  if (is_id(text, most)) return {};
  return fmt::format(
      "{} is not an id: 1 to {} of the characters A-Z a-z 0-9 _ - . are allowed, "
      "the first not - or .",
      quote(text), most);
}

std::size_t underscore_between_ids(std::string_view text) noexcept {
  const std::size_t last = text.rfind('_');
  for (std::size_t at = last; at != std::string_view::npos && at > 0;
       at = text.rfind('_', at - 1)) {
    if (is_id(text.substr(0, at)) && is_id(text.substr(at + 1))) return at;
  }
  return last;
}

bool is_file_name(std::string_view text) noexcept {
  return !text.empty() && text.size() <= kLongestFileName && text[0] != '.' &&
         std::ranges::none_of(text, [](char c) {
           return c == '/' || c == '\\' || is_control(static_cast<unsigned char>(c));
         });
}

std::string quote(std::string_view text, std::size_t most) {
  if (text.size() <= most) return fmt::format("{:?}", text);
  return fmt::format("{:?}... ({} bytes)", utf8_prefix(text, most), text.size());
}

std::string printable(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(length, 1));
    if (length == 0) {
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[0]));
    } else if (const std::uint32_t code = code_of(character); !is_unsafe(code)) {
      result += character;
    } else {
      result += code < 0x80 ? fmt::format("\\x{:02x}", code) : fmt::format("\\u{{{:x}}}", code);
    }
    text.remove_prefix(character.size());
  }
  return result;
}

}  // namespace enfilade
