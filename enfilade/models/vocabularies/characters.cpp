#include "enfilade/models/vocabularies/characters.h"

#include <utf8proc.h>
#include <algorithm>
#include <array>
#include <span>
#include <utility>

namespace enfilade::models::vocabularies {
namespace {

constexpr std::uint32_t kReplacement = 0xfffd;

utf8proc_category_t category(std::uint32_t code) {
  return utf8proc_category(static_cast<utf8proc_int32_t>(code));
}
bool is_between(utf8proc_category_t kind, utf8proc_category_t first, utf8proc_category_t last) {
  return kind >= first && kind <= last;
}

bool is_blank(std::uint32_t code) {
  return code == '\t' || code == '\n' || code == '\r' ||
         is_between(category(code), UTF8PROC_CATEGORY_ZS, UTF8PROC_CATEGORY_ZP);
}

bool is_dropped(std::uint32_t code) {
  if (code == '\t' || code == '\n' || code == '\r') return false;
  return code == kReplacement ||
         is_between(category(code), UTF8PROC_CATEGORY_CC, UTF8PROC_CATEGORY_CO);
}

// The blocks of BERT's code: no kana, no Hangul, which are written with blanks or as words.
bool is_chinese(std::uint32_t code) {
  constexpr std::array<std::pair<std::uint32_t, std::uint32_t>, 8> kBlocks{{{0x3400, 0x4dbf},
                                                                            {0x4e00, 0x9fff},
                                                                            {0xf900, 0xfaff},
                                                                            {0x20000, 0x2a6df},
                                                                            {0x2a700, 0x2b73f},
                                                                            {0x2b740, 0x2b81f},
                                                                            {0x2b820, 0x2ceaf},
                                                                            {0x2f800, 0x2fa1f}}};
  return std::ranges::any_of(
      kBlocks, [code](const auto& block) { return code >= block.first && code <= block.second; });
}

// All of ASCII's signs count, also those that Unicode calls symbols: $ + < = > ^ ` | ~.
bool is_punctuation(std::uint32_t code) {
  const utf8proc_category_t kind = category(code);
  return is_between(kind, UTF8PROC_CATEGORY_PC, UTF8PROC_CATEGORY_PO) ||
         (code < 0x80 && is_between(kind, UTF8PROC_CATEGORY_SM, UTF8PROC_CATEGORY_SO));
}

// Canonical decomposition (NFD) without accents, in lower case.
void append_folded(std::uint32_t code, std::u32string& text) {
  std::array<utf8proc_int32_t, 4> parts{};  // no character has more
  int boundary = 0;
  const utf8proc_ssize_t count =
      utf8proc_decompose_char(static_cast<utf8proc_int32_t>(code), parts.data(), parts.size(),
                              UTF8PROC_DECOMPOSE, &boundary);
  for (const utf8proc_int32_t part : std::span(parts).first(static_cast<std::size_t>(count))) {
    if (utf8proc_category(part) == UTF8PROC_CATEGORY_MN) continue;
    text += static_cast<char32_t>(utf8proc_tolower(part));
  }
}

}  // namespace

std::uint32_t take_character(std::string_view& text) {
  utf8proc_int32_t code = 0;
  const utf8proc_ssize_t length =
      utf8proc_iterate(reinterpret_cast<const utf8proc_uint8_t*>(text.data()),
                       static_cast<utf8proc_ssize_t>(text.size()), &code);
  text.remove_prefix(static_cast<std::size_t>(std::max<utf8proc_ssize_t>(length, 1)));
  return length > 0 ? static_cast<std::uint32_t>(code) : kReplacement;
}

std::vector<std::u32string> words_of(std::string_view text, Letters letters) {
  std::u32string clean;
  while (!text.empty()) {
    const std::uint32_t code = take_character(text);
    if (is_dropped(code)) continue;
    if (is_blank(code)) {
      clean += U' ';
    } else if (is_chinese(code)) {
      clean += U' ';
      letters == Letters::kFolded ? append_folded(code, clean)
                                  : clean.push_back(static_cast<char32_t>(code));
      clean += U' ';
    } else if (letters == Letters::kFolded) {
      append_folded(code, clean);
    } else {
      clean += static_cast<char32_t>(code);
    }
  }
  std::vector<std::u32string> words;
  bool open = false;  // whether the last word goes on
  for (const char32_t code : clean) {
    const bool mark = is_punctuation(code);
    if (code == U' ') {
      open = false;
      continue;
    }
    if (!open || mark) words.emplace_back();
    words.back() += code;
    open = !mark;
  }
  return words;
}

}  // namespace enfilade::models::vocabularies
