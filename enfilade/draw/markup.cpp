#include "enfilade/draw/markup.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "enfilade/core/utf8.h"

namespace enfilade::draw {
namespace {

using Escape = std::pair<char, std::string_view>;
constexpr std::array<Escape, 5> kEscapes{
    {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&#39;"}}};
constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

// Bytes of the character at the head of `text`; 0 if there is none that XML allows.
std::size_t character_length(std::string_view text) {
  const auto head = static_cast<unsigned char>(text[0]);
  if (head < 0x20 && head != '\t' && head != '\n') return 0;
  const std::size_t length = utf8_length(text);
  const std::string_view c = text.substr(0, length);
  return c == "\xEF\xBF\xBE" || c == "\xEF\xBF\xBF" ? 0 : length;  // U+FFFE, U+FFFF
}

}  // namespace

std::string escape(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = character_length(text);
    const auto* const known = std::ranges::find(kEscapes, text[0], &Escape::first);
    if (known != kEscapes.end()) {
      out += known->second;
    } else {
      out += length == 0 ? kReplacement : text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

}  // namespace enfilade::draw
