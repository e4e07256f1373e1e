#include "enfilade/core/written_lists.h"

#include <algorithm>
#include <utility>

#include "enfilade/core/gzip.h"
#include "enfilade/core/utf8.h"

namespace enfilade {
namespace {

constexpr std::string_view kNoBreakSpace = "\xC2\xA0";
constexpr std::string_view kBlanks = " \t\r\n\v\f";
constexpr std::uint32_t kReplacement = 0xFFFD;

/// \param low  the byte of a unit that has its lower bits: 0 or 1
std::string from_utf16(std::string_view bytes, std::size_t low) {
  const auto unit = [&](std::size_t at) {
    const auto of = [&](std::size_t k) { return static_cast<unsigned char>(bytes[at + k]); };
    return static_cast<std::uint32_t>(of(low) | (of(1 - low) << 8U));
  };
  std::string text;
  text.reserve(bytes.size() / 2);
  std::size_t at = 0;
  for (; at + 1 < bytes.size(); at += 2) {
    const std::uint32_t first = unit(at);
    const bool pair = first >= 0xD800U && first < 0xDC00U && at + 3 < bytes.size();
    const std::uint32_t second = pair ? unit(at + 2) : 0;
    if (second >= 0xDC00U && second < 0xE000U) {
      append_utf8(0x10000U + ((first - 0xD800U) << 10U) + (second - 0xDC00U), text);
      at += 2;
    } else {
      append_utf8(first >= 0xD800U && first < 0xE000U ? kReplacement : first, text);
    }
  }
  if (at < bytes.size()) append_utf8(kReplacement, text);  // half a unit
  return text;
}

}  // namespace

std::string plain_text(std::string content) {
  if (content.starts_with(kByteOrderMark)) {
    content.erase(0, kByteOrderMark.size());
  } else if (content.starts_with("\xFF\xFE")) {
    return from_utf16(std::string_view(content).substr(2), 0);
  } else if (content.starts_with("\xFE\xFF")) {
    return from_utf16(std::string_view(content).substr(2), 1);
  }
  return content;
}

std::string read_plain_text(const std::filesystem::path& file, std::size_t most) {
  return plain_text(read_text_file(file, most));
}

std::string_view trimmed(std::string_view text) noexcept {
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
    if (!text.starts_with(kNoBreakSpace)) break;
    text.remove_prefix(kNoBreakSpace.size());
  }
  for (;;) {
    text = text.substr(0, text.find_last_not_of(kBlanks) + 1);  // npos + 1 is 0
    if (!text.ends_with(kNoBreakSpace)) break;
    text.remove_suffix(kNoBreakSpace.size());
  }
  return text;
}

std::vector<ListLine> list_lines(std::string_view text, HashLines hash) {
  std::vector<ListLine> lines;
  std::size_t number = 0;
  for (const std::string_view whole : all_lines(text)) {
    const std::string_view line = trimmed(whole);
    ++number;
    const bool comment = hash == HashLines::kComments && line.starts_with('#');
    if (!line.empty() && !comment) lines.push_back({number, line});
  }
  return lines;
}

std::vector<std::string_view> all_lines(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    lines.push_back(text.substr(0, end));
    const bool pair = text.substr(end).starts_with("\r\n");
    text.remove_prefix(std::min(end + (pair ? 2 : 1), text.size()));
  }
  return lines;
}

}  // namespace enfilade
