#include "enfilade/service/detail/texts.h"

#include <algorithm>

#include "enfilade/core/utf8.h"

namespace enfilade::service::detail {
namespace {

constexpr std::size_t kLongestName = 40;
constexpr std::size_t kLongestExternalId = 100;

/// Of one character. U+0080 to U+009F are controls too; U+202A to U+202E and U+2066 to U+2069 turn
/// text around.
bool is_printable(std::string_view c) {
  const auto first = static_cast<unsigned char>(c.front());
  if (first < 0x20 || first == 0x7F) return false;
  if (c.size() == 2) return c < "\xC2\x80" || c > "\xC2\x9F";
  return c.size() != 3 || !((c >= "\xE2\x80\xAA" && c <= "\xE2\x80\xAE") ||
                            (c >= "\xE2\x81\xA6" && c <= "\xE2\x81\xA9"));
}

enum class Breaks { kForbidden, kAllowed };

bool is_text(std::string_view text, std::size_t most, Breaks breaks) {
  std::size_t characters = 0;
  for (; !text.empty(); ++characters) {
    const std::size_t size = utf8_length(text);
    if (size == 0) return false;
    const bool is_break = text.front() == '\n' || text.front() == '\t';
    if (!(is_break && breaks == Breaks::kAllowed) && !is_printable(text.substr(0, size))) {
      return false;
    }
    text.remove_prefix(size);
  }
  return characters > 0 && characters <= most;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_small(char c) { return c >= 'a' && c <= 'z'; }
bool is_mark(char c) { return c == '-' || c == '_'; }

}  // namespace

bool is_label(std::string_view text, std::size_t most) {
  return is_text(text, most, Breaks::kForbidden) && text.front() != ' ' && text.back() != ' ';
}

bool is_prose(std::string_view text, std::size_t most) {
  return is_text(text, most, Breaks::kAllowed);
}

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= kLongestName &&
         std::ranges::all_of(text, [](char c) { return is_small(c) || is_digit(c) || is_mark(c); });
}

bool is_external_id(std::string_view text) {
  return !text.empty() && text.size() <= kLongestExternalId &&
         std::ranges::all_of(text, [](char c) {
           return is_small(c) || (c >= 'A' && c <= 'Z') || is_digit(c) || is_mark(c);
         });
}

std::string sheet_text(const std::string& text) {
  std::string out = "\"";
  if (!text.empty() && std::string_view("=+-@").find(text.front()) != std::string_view::npos) {
    out += '\'';
  }
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + '"';
}

}  // namespace enfilade::service::detail
