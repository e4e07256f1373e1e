#include "enfilade/neural/panoramic/recording.h"

#include <ATen/ATen.h>
#include <string>
#include <utility>
#include <vector>

namespace enfilade::neural::panoramic {
namespace {

std::vector<float> first_of_row(const at::Tensor& values, std::size_t row, std::size_t count) {
  const at::Tensor one =
      values.select(0, static_cast<std::int64_t>(row)).to(at::kCPU, at::kFloat).contiguous();
  const float* data = one.data_ptr<float>();
  return {data, data + count};
}

}  // namespace

PanoramicRecording::PanoramicRecording(const PanoramicSplit& split)
    : recorder_(models::AgentKind::kPanoramic, split.episodes().episodes.size()) {
  for (std::size_t i = 0; i < split.episodes().episodes.size(); ++i) {
    std::vector<std::string> text;
    for (const std::int64_t id : split.words(i)) text.push_back(split.vocabulary().word(id));
    recorder_.read(i, std::move(text));
  }
}

BatchObserver PanoramicRecording::observer(std::span<const std::size_t> episodes) {
  return [this, episodes](const PanoramicSplit::Batch& batch, const PanoramicStep& step) {
    for (std::size_t row = 0; row < step.walks.size(); ++row) {
      if (step.walks[row].ended()) continue;
      add(step, row, episodes[batch.places[row]],
          static_cast<std::size_t>(batch.words.lengths[row]));
    }
  };
}

void PanoramicRecording::add(const PanoramicStep& step, std::size_t row, std::size_t episode,
                             std::size_t words) {
  const PanoramicEpisode& walk = step.walks[row];
  const std::size_t stop = walk.stop();
  const auto shares = models::probabilities(first_of_row(step.output.logits, row, stop + 1));
  models::RecordedStep recorded{walk.location().viewpoint, walk.heading(), walk.elevation()};
  recorded.attention = first_of_row(step.output.word_attention, row, words);
  recorded.choices.push_back({std::nullopt, shares[stop]});
  for (std::size_t k = 0; k < stop; ++k) {
    recorded.choices.push_back({walk.candidates()[k].viewpoint, shares[k]});
  }
  const std::size_t choice = step.choices[row];
  recorded.chosen = choice == stop ? 0 : choice + 1;
  if (choice != stop) recorded.way = {walk.candidates()[choice].viewpoint};
  recorder_.add(episode, std::move(recorded));
}

}  // namespace enfilade::neural::panoramic
