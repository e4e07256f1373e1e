#include "enfilade/tasks/tokenizer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <iterator>
#include <ranges>
#include <sstream>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/tasks/formats/characters.h"

namespace enfilade::tasks {
namespace {

using formats::is_word;
using formats::lower;
using formats::strip;

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
  std::vector<std::string> words;
  std::istringstream lines(read_file(file));
  for (std::string line; std::getline(lines, line);) {
    if (line.ends_with('\r')) line.pop_back();
    words.push_back(line);
  }
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
      report(where, "bad-special", fmt::format("{:?}, not {:?}", word, kSpecials[i]));
    } else if (word.empty()) {
      report(where, "empty-word", "no word; one word a line is expected");
    }
    const auto [at, fresh] = first.emplace(word, i);
    if (!fresh && !word.empty()) {
      report(where, "repeated-word",
             fmt::format("{:?} stands in line {} already", word, at->second + 1));
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

}  // namespace enfilade::tasks
