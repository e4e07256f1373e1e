#include "enfilade/models/vocabularies/characters.h"

#include <algorithm>
#include <iterator>
#include <span>

#include "enfilade/core/utf8.h"
#include "enfilade/models/vocabularies/unicode_tables.h"

namespace enfilade::models::vocabularies {
namespace {

constexpr std::uint32_t kReplacement = 0xfffd;

// Whether one of the sorted ranges has it.
template <std::size_t N>
bool among(const std::array<CodeRange, N>& ranges, std::uint32_t code) {
  const auto after = std::ranges::upper_bound(ranges, code, {}, &CodeRange::first);
  return after != ranges.begin() && code <= std::prev(after)->last;
}

bool is_blank(std::uint32_t code) {
  // White_Space without the control characters that are dropped before.
  constexpr std::array<CodeRange, 10> kBlanks{{{0x9, 0xa},
                                               {0xd, 0xd},
                                               {0x20, 0x20},
                                               {0xa0, 0xa0},
                                               {0x1680, 0x1680},
                                               {0x2000, 0x200a},
                                               {0x2028, 0x2029},
                                               {0x202f, 0x202f},
                                               {0x205f, 0x205f},
                                               {0x3000, 0x3000}}};
  return among(kBlanks, code);
}

bool is_dropped(std::uint32_t code) {
  if (code == '\t' || code == '\n' || code == '\r') return false;
  return code == 0 || code == kReplacement || among(kControls, code);
}

// The blocks of BERT's code: no kana, no Hangul, which are written with blanks or as words.
bool is_chinese(std::uint32_t code) {
  constexpr std::array<CodeRange, 8> kBlocks{{{0x3400, 0x4dbf},
                                              {0x4e00, 0x9fff},
                                              {0xf900, 0xfaff},
                                              {0x20000, 0x2a6df},
                                              {0x2a700, 0x2b73f},
                                              {0x2b740, 0x2b81f},
                                              {0x2b820, 0x2ceaf},
                                              {0x2f800, 0x2fa1f}}};
  return among(kBlocks, code);
}

// All of ASCII's signs count, also those that Unicode calls symbols: $ + < = > ^ ` | ~.
bool is_punctuation(std::uint32_t code) {
  if (code < 0x80) {
    return (code >= 33 && code <= 47) || (code >= 58 && code <= 64) || (code >= 91 && code <= 96) ||
           (code >= 123 && code <= 126);
  }
  return among(kPunctuation, code);
}

std::uint32_t lower(std::uint32_t code) {
  const auto after = std::ranges::upper_bound(kLowerCase, code, {}, &LowerCase::first);
  if (after == kLowerCase.begin()) return code;
  const LowerCase& run = *std::prev(after);
  if (code > run.last || (code - run.first) % run.step != 0) return code;
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(code) + run.shift);
}

// Korean syllables fall apart into letters (Unicode 3.12).
void append_letters_of(std::uint32_t syllable, std::u32string& text) {
  constexpr std::uint32_t kFirst = 0xac00, kLead = 0x1100, kVowel = 0x1161, kTail = 0x11a7;
  constexpr std::uint32_t kVowels = 21, kTails = 28;
  const std::uint32_t index = syllable - kFirst;
  text += static_cast<char32_t>(kLead + index / (kVowels * kTails));
  text += static_cast<char32_t>(kVowel + index / kTails % kVowels);
  if (index % kTails != 0) text += static_cast<char32_t>(kTail + index % kTails);
}

void append_folded(std::uint32_t code, std::u32string& text) {
  if (code < 0x80) {
    text += static_cast<char32_t>(code >= 'A' && code <= 'Z' ? code + 32 : code);
    return;
  }
  if (code >= 0xac00 && code <= 0xd7a3) return append_letters_of(code, text);
  if (among(kMarks, code)) return;
  const auto found = std::ranges::lower_bound(kBases, code, {}, &Bases::code);
  if (found == kBases.end() || found->code != code) {
    text += static_cast<char32_t>(lower(code));
    return;
  }
  for (const std::uint32_t base : found->bases) {
    if (base != 0) text += static_cast<char32_t>(lower(base));
  }
}

}  // namespace

std::uint32_t take_character(std::string_view& text) {
  const std::size_t length = utf8_length(text);
  if (length == 0) {
    text.remove_prefix(1);
    return kReplacement;
  }
  constexpr std::array<unsigned, 5> kLeadBits{0, 0x7f, 0x1f, 0x0f, 0x07};
  std::uint32_t code = static_cast<unsigned char>(text[0]) & kLeadBits.at(length);
  for (std::size_t k = 1; k < length; ++k) {
    code = (code << 6U) | (static_cast<unsigned char>(text[k]) & 0x3fU);
  }
  text.remove_prefix(length);
  return code;
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
