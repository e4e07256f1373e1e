#include "enfilade/models/instruction_words.h"

#include <algorithm>
#include <utility>

namespace enfilade::models {

using tasks::Vocabulary;

InstructionWords::InstructionWords(Vocabulary words)
    : size_(words.size() + 2),
      begin_(static_cast<std::int64_t>(words.size())),
      end_(Vocabulary::kEnd),
      pad_(Vocabulary::kPad),
      mask_(begin_ + 1),
      words_(std::move(words)) {}

InstructionWords::InstructionWords(Subwords pieces)
    : size_(pieces.size()),
      begin_(pieces.begin()),
      end_(pieces.end()),
      pad_(pieces.pad()),
      mask_(pieces.mask()),
      words_(std::move(pieces)) {}

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

Vocabulary training_vocabulary(const tasks::EpisodeSet& episodes, std::size_t least_count) {
  std::vector<std::string> texts;
  texts.reserve(episodes.episodes.size());
  for (const tasks::Episode& episode : episodes.episodes) texts.push_back(episode.text);
  return Vocabulary::build(texts, least_count);
}

EncodedInstructions::EncodedInstructions(const tasks::EpisodeSet& episodes,
                                         const Vocabulary& vocabulary, std::size_t max_words)
    : size_(episodes.episodes.size()), max_words_(max_words) {
  ids_.reserve(size_ * max_words);
  for (const tasks::Episode& episode : episodes.episodes) {
    const std::vector<std::uint32_t> row = vocabulary.encode(episode.text, max_words);
    ids_.insert(ids_.end(), row.begin(), row.end());
  }
}

void EncodedInstructions::gather(std::span<const std::size_t> episodes,
                                 std::span<std::uint32_t> out) const {
  for (std::size_t i = 0; i < episodes.size(); ++i) {
    std::ranges::copy(row(episodes[i]), out.subspan(i * max_words_).begin());
  }
}

std::size_t word_count(std::span<const std::uint32_t> row) {
  return static_cast<std::size_t>(std::ranges::find(row, Vocabulary::kPad) - row.begin());
}

ReadingOrder reading_order(std::span<const std::uint32_t> row, const Vocabulary& vocabulary) {
  std::size_t words = word_count(row);
  const bool whole = words > 0 && row[words - 1] == Vocabulary::kEnd;
  if (whole) --words;
  ReadingOrder order;
  for (std::size_t i = words; i-- > 0;) order.places.push_back(i);
  if (whole) order.places.push_back(words);
  for (const std::size_t place : order.places) {
    order.words.push_back(vocabulary.words().at(row[place]));
  }
  return order;
}

}  // namespace enfilade::models
