#include "enfilade/tasks/tokenizer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <optional>
#include <ranges>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/written_lists.h"
#include "enfilade/tasks/continuous_episodes.h"

namespace enfilade::tasks {
namespace {

// Classes of characters of Python's re and str, in ASCII, whatever the C library's locale.

// A letter, a digit or _. Bytes above 127 count as letters.
constexpr bool is_word(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte > 127 || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
         c == '_';
}

constexpr bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r') || (c >= 28 && c <= 31);
}

// Without the blanks at both ends.
constexpr std::string_view strip(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

// With lower-case letters; bytes above 127 are left as they are.
std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

constexpr std::array<std::string_view, 3> kSpecials{"<PAD>", "<UNK>", "<EOS>"};

// As Python's string.punctuation.
bool is_punctuation(char c) { return c > 32 && c < 127 && (!is_word(c) || c == '_'); }

void add_piece(std::string_view piece, std::vector<std::string>& tokens) {
  piece = strip(piece);
  if (piece.empty()) return;
  // A piece such as ", ." has a space in it and so stays one token: the released code's way.
  const bool apart = std::ranges::all_of(piece, is_punctuation) &&
                     !std::ranges::all_of(piece, [](char c) { return c == '.'; });
  if (!apart) {
    tokens.push_back(lower(piece));
    return;
  }
  for (const char c : piece) tokens.emplace_back(1, c);
}

}  // namespace

std::vector<std::string> tokenize(std::string_view text) {
  std::vector<std::string> tokens;
  for (std::size_t begin = 0; begin < text.size();) {
    const bool word = is_word(text[begin]);
    std::size_t end = begin + 1;
    while (end < text.size() && is_word(text[end]) == word) ++end;
    add_piece(text.substr(begin, end - begin), tokens);
    begin = end;
  }
  return tokens;
}

Vocabulary::Vocabulary(std::vector<std::string> words) : words_(std::move(words)) {
  ids_.reserve(words_.size());
  for (std::size_t i = 0; i < words_.size(); ++i) {
    ids_.emplace(words_[i], static_cast<std::uint32_t>(i));
  }
}

Vocabulary Vocabulary::build(std::span<const std::string> texts, std::size_t least_count) {
  std::unordered_map<std::string, std::size_t> counts;
  for (const std::string& text : texts) {
    for (std::string& token : tokenize(text)) ++counts[std::move(token)];
  }
  std::vector<std::pair<std::string, std::size_t>> kept;
  std::ranges::copy_if(counts, std::back_inserter(kept),
                       [&](const auto& entry) { return entry.second >= least_count; });
  std::ranges::sort(kept, [](const auto& a, const auto& b) {
    return a.second != b.second ? a.second > b.second : a.first < b.first;
  });
  std::vector<std::string> words(kSpecials.begin(), kSpecials.end());
  for (auto& [word, n] : kept) words.push_back(std::move(word));
  return Vocabulary(std::move(words));
}

Vocabulary Vocabulary::load(const std::filesystem::path& file) {
  const std::string text = read_plain_text(file);
  std::vector<std::string> words;
  for (const std::string_view line : all_lines(text)) words.emplace_back(line);
  while (!words.empty() && words.back().empty()) words.pop_back();
  return of(std::move(words), file.string());
}

Vocabulary Vocabulary::of(std::vector<std::string> words, const std::string& origin) {
  std::vector<Diagnostic> faults;
  const auto report = [&](std::string where, const char* code, std::string message) {
    faults.push_back({Severity::kError, origin, std::move(where), code, std::move(message)});
  };
  std::unordered_map<std::string, std::size_t> first;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const std::string where = fmt::format("line {}", i + 1);
    if (i < kSpecials.size() && word != kSpecials[i]) {
      report(where, "bad-special", fmt::format("{}, not {}", quote(word), quote(kSpecials[i])));
    } else if (word.empty()) {
      report(where, "empty-word", "no word; one word a line is expected");
    }
    const auto [at, fresh] = first.emplace(word, i);
    if (!fresh && !word.empty()) {
      report(where, "repeated-word",
             fmt::format("{} stands in line {} already", quote(word), at->second + 1));
    }
  }
  if (words.size() < kSpecials.size()) {
    report("", "too-short",
           fmt::format("{} lines; the first three must be {}", words.size(),
                       fmt::join(kSpecials, ", ")));
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return Vocabulary(std::move(words));
}

void Vocabulary::save(const std::filesystem::path& file) const {
  write_file_atomically(file, fmt::format("{}\n", fmt::join(words_, "\n")));
}

std::uint32_t Vocabulary::id(std::string_view word) const {
  const auto found = ids_.find(std::string(word));
  return found == ids_.end() ? kUnknown : found->second;
}

std::vector<std::uint32_t> Vocabulary::encode(std::string_view text, std::size_t length) const {
  std::vector<std::uint32_t> ids;
  for (const std::string& token : tokenize(text)) ids.push_back(id(token));
  std::ranges::reverse(ids);
  ids.push_back(kEnd);
  ids.resize(length, kPad);
  return ids;
}

std::string Vocabulary::decode(std::span<const std::uint32_t> ids) const {
  std::string text;
  for (const std::uint32_t i : ids | std::views::reverse) {
    if (i == kPad || i == kEnd) continue;
    if (!text.empty()) text += ' ';
    text += words_[i < words_.size() ? i : kUnknown];
  }
  return text;
}

namespace {

constexpr std::int64_t kMostToken = std::numeric_limits<std::int32_t>::max();

std::int32_t token_of(std::optional<std::int64_t> given, std::int32_t otherwise,
                      std::string_view name) {
  if (!given) return otherwise;
  check_range(name, static_cast<double>(*given), 0, static_cast<double>(kMostToken));
  return static_cast<std::int32_t>(*given);
}

std::string prepared(std::string_view text) {
  std::string result;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text.substr(at).starts_with("'s") || text.substr(at).starts_with("'S")) result += ' ';
    if (text[at] != ',' && text[at] != '?') result += text[at];
  }
  return lower(result);
}

bool belongs_to_word(char c) { return is_word(c) || c == '-'; }

}  // namespace

std::vector<std::string> tokenize_continuous(std::string_view text) {
  const std::string whole = prepared(text);
  std::vector<std::string> tokens;
  for (std::size_t begin = 0; begin < whole.size();) {
    const bool word = belongs_to_word(whole[begin]);
    std::size_t end = begin + 1;
    while (end < whole.size() && belongs_to_word(whole[end]) == word) ++end;
    const auto piece = strip(std::string_view(whole).substr(begin, end - begin));
    if (!piece.empty()) tokens.emplace_back(piece);
    begin = end;
  }
  return tokens;
}

InstructionEncoder::InstructionEncoder(const InstructionVocabulary& vocabulary)
    : unknown_(token_of(vocabulary.unknown, 1, "UNK_INDEX")),
      padding_(token_of(vocabulary.padding, 0, "PAD_INDEX")) {
  check_range("words", static_cast<double>(vocabulary.words.size()), 1,
              static_cast<double>(kMostToken));
  for (const std::string& word : vocabulary.words) {
    const auto [first, fresh] = ids_.emplace(word, static_cast<std::int32_t>(ids_.size()));
    if (!fresh) {
      throw ArgumentError(
          fmt::format("word {} is there twice; the first is token {}", quote(word), first->second));
    }
  }
}

std::vector<std::int32_t> InstructionEncoder::encode(std::string_view text,
                                                     std::size_t length) const {
  std::vector<std::int32_t> tokens;
  tokens.reserve(length);
  for (const std::string& word : tokenize_continuous(text)) {
    if (tokens.size() == length) break;
    const auto found = ids_.find(word);
    tokens.push_back(found == ids_.end() ? unknown_ : found->second);
  }
  tokens.resize(length, padding_);
  return tokens;
}

}  // namespace enfilade::tasks
