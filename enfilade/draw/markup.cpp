#include "enfilade/draw/markup.h"

#include <cstddef>

#include "enfilade/core/utf8.h"

namespace enfilade::draw {
namespace {

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
    switch (text[0]) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += length == 0 ? kReplacement : text.substr(0, length);
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

}  // namespace enfilade::draw
