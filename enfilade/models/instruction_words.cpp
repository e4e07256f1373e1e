#include "enfilade/models/instruction_words.h"

#include <algorithm>
#include <utility>

namespace enfilade::models {

using tasks::Vocabulary;

InstructionWords::InstructionWords(Vocabulary words) : words_(std::move(words)) {}
InstructionWords::InstructionWords(Subwords pieces) : words_(std::move(pieces)) {}

std::size_t InstructionWords::size() const noexcept {
  const Vocabulary* const words = vocabulary();
  return words != nullptr ? words->size() + 2 : std::get<Subwords>(words_).size();
}

std::int64_t InstructionWords::begin() const noexcept {
  const Vocabulary* const words = vocabulary();
  return words != nullptr ? static_cast<std::int64_t>(words->size())
                          : std::get<Subwords>(words_).begin();
}

std::int64_t InstructionWords::end() const noexcept {
  return vocabulary() != nullptr ? Vocabulary::kEnd : std::get<Subwords>(words_).end();
}

std::int64_t InstructionWords::pad() const noexcept {
  return vocabulary() != nullptr ? Vocabulary::kPad : std::get<Subwords>(words_).pad();
}

std::optional<std::int64_t> InstructionWords::mask() const {
  if (vocabulary() != nullptr) return begin() + 1;
  const auto mask = std::get<Subwords>(words_).mask();
  if (!mask) return std::nullopt;
  return *mask;
}

std::string InstructionWords::word(std::int64_t id) const {
  const Vocabulary* const words = vocabulary();
  if (words == nullptr) {
    return std::string(std::get<Subwords>(words_).piece(static_cast<std::uint32_t>(id)));
  }
  if (id == begin()) return "<BOS>";
  if (id == mask()) return "<MASK>";
  return words->words()[static_cast<std::size_t>(id)];
}

std::vector<std::int64_t> InstructionWords::encode(std::string_view text, std::size_t most) const {
  std::vector<std::int64_t> ids;
  if (const Vocabulary* const words = vocabulary()) {
    ids.push_back(begin());
    for (const std::string& word : tasks::tokenize(text)) ids.push_back(words->id(word));
    ids.push_back(end());
  } else {
    for (const std::int32_t id : std::get<Subwords>(words_).encode(text)) ids.push_back(id);
  }
  if (ids.size() > most) {
    ids.resize(most);
    ids.back() = end();
  }
  return ids;
}

std::vector<std::int64_t> InstructionWords::encode(const tasks::Episode& episode,
                                                   std::size_t most) const {
  const std::vector<std::int32_t>& given = episode.details.tokens;
  const auto is_id = [&](std::int32_t id) {
    return id >= 0 && static_cast<std::size_t>(id) < size();
  };
  const bool usable = vocabulary() == nullptr && given.size() >= 2 && given.front() == begin() &&
                      given.back() == end() && std::ranges::all_of(given, is_id);
  if (!usable) return encode(episode.text, most);
  return {given.begin(), given.begin() + static_cast<std::ptrdiff_t>(std::min(most, given.size()))};
}

std::vector<std::vector<std::int64_t>> InstructionWords::encode(const tasks::EpisodeSet& episodes,
                                                                std::size_t most,
                                                                bool reads) const {
  std::vector<std::vector<std::int64_t>> all;
  all.reserve(episodes.episodes.size());
  for (const tasks::Episode& episode : episodes.episodes) {
    all.push_back(reads ? encode(episode, most) : encode("", most));
  }
  return all;
}

}  // namespace enfilade::models
