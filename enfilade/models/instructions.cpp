#include "enfilade/models/instructions.h"

#include <algorithm>

namespace enfilade::models {

tasks::Vocabulary training_vocabulary(const tasks::EpisodeSet& episodes, std::size_t least_count) {
  std::vector<std::string> texts;
  texts.reserve(episodes.episodes.size());
  for (const tasks::Episode& episode : episodes.episodes) texts.push_back(episode.text);
  return tasks::Vocabulary::build(texts, least_count);
}

EncodedInstructions::EncodedInstructions(const tasks::EpisodeSet& episodes,
                                         const tasks::Vocabulary& vocabulary, std::size_t max_words)
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
  return static_cast<std::size_t>(std::ranges::find(row, tasks::Vocabulary::kPad) - row.begin());
}

ReadingOrder reading_order(std::span<const std::uint32_t> row,
                           const tasks::Vocabulary& vocabulary) {
  std::size_t words = word_count(row);
  const bool whole = words > 0 && row[words - 1] == tasks::Vocabulary::kEnd;
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
