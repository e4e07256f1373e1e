// The tokens of VLN-CE's instructions: enfilade/tasks/instruction_tokens.h.
#include <fmt/format.h>
#include <algorithm>
#include <limits>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/formats/characters.h"
#include "enfilade/tasks/instruction_tokens.h"

namespace enfilade::tasks {
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
  return formats::lower(result);
}

bool belongs_to_word(char c) { return formats::is_word(c) || c == '-'; }

}  // namespace

std::vector<std::string> tokenize_continuous(std::string_view text) {
  const std::string whole = prepared(text);
  std::vector<std::string> tokens;
  for (std::size_t begin = 0; begin < whole.size();) {
    const bool word = belongs_to_word(whole[begin]);
    std::size_t end = begin + 1;
    while (end < whole.size() && belongs_to_word(whole[end]) == word) ++end;
    const auto piece = formats::strip(std::string_view(whole).substr(begin, end - begin));
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
          fmt::format("word {:?} is there twice; the first is token {}", word, first->second));
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
