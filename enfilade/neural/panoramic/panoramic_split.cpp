#include "enfilade/neural/panoramic/panoramic_split.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/models/decision_recorder.h"
#include "enfilade/neural/core/split_rollout.h"

namespace enfilade::neural::panoramic {
namespace {

// Records the steps of rollout_episodes(). One thread at a time.
class PanoramicRecording {
 public:
  // Of all episodes of a split.
  explicit PanoramicRecording(const PanoramicSplit& split);

  // An observer of a walk of these episodes, which have to stay as long as it is used.
  BatchObserver observer(std::span<const std::size_t> episodes);
  const models::DecisionRecorder& recorder() const noexcept { return recorder_; }

 private:
  void add(const PanoramicStep& step, std::size_t row, std::size_t episode, std::size_t words);

  models::DecisionRecorder recorder_;
};

std::vector<float> first_of_row(const at::Tensor& values, std::size_t row, std::size_t count) {
  const at::Tensor one =
      values.select(0, static_cast<std::int64_t>(row)).to(at::kCPU, at::kFloat).contiguous();
  const float* data = one.data_ptr<float>();
  return {data, data + count};
}

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

}  // namespace

PanoramicSplit::PanoramicSplit(const tasks::EpisodeSet& episodes,
                               const models::InstructionWords& words,
                               const models::TrainConfig& config,
                               const features::FeatureSet* features)
    : episodes_(episodes),
      vocabulary_(words),
      max_actions_(config.max_steps),
      words_(words.encode(episodes, config.network.max_words, config.network.inputs.language)),
      panoramas_(episodes.graphs) {
  if (features != nullptr) features_.emplace(*features, episodes);
  images_ = pictures_of(features_ ? &*features_ : nullptr);
}

core::ResidentViews* PanoramicSplit::resident(c10::Device device) {
  if (device.is_cpu() || !features_) return nullptr;
  if (!resident_) {
    const std::size_t columns = features_->dimensions();
    resident_.emplace(static_cast<std::int64_t>(columns), device,
                      [this, columns](graph::Location at, std::span<float> out) {
                        for (std::uint32_t view = 0; view < core::ViewFeatures::kViews; ++view) {
                          images_(at, view, out.subspan(view * columns, columns));
                        }
                      });
  }
  return &*resident_;
}

PanoramicSplit::Batch PanoramicSplit::begin(std::span<const std::size_t> episodes) {
  Batch batch;
  batch.places.resize(episodes.size());
  std::iota(batch.places.begin(), batch.places.end(), std::size_t{0});
  std::ranges::stable_sort(batch.places, std::ranges::greater{},
                           [&](std::size_t place) { return words_[episodes[place]].size(); });
  std::vector<std::vector<std::int64_t>> sentences;
  for (const std::size_t place : batch.places) {
    const std::size_t index = episodes[place];
    sentences.push_back(words_[index]);
    const tasks::ReferencePath& path = episodes_.path_of(episodes_.episodes[index]);
    EpisodeStart start{{path.scan, path.viewpoints.front()}, path.heading, std::nullopt};
    if (!goal_hidden(path)) start.goal = path.viewpoints.back();
    batch.walks.emplace_back(panoramas_, *episodes_.graphs, start);
  }
  batch.words = batch_words(sentences);
  return batch;
}

std::vector<tasks::Trajectory> rollout_episodes(PanoramicNetwork& network, PanoramicSplit& split,
                                                std::span<const std::size_t> episodes,
                                                const BatchObserver& observer) {
  const c10::NoGradGuard no_gradients;
  network.set_dropout(std::nullopt);
  PanoramicRolloutOptions options;
  options.max_actions = split.max_actions();
  options.resident = split.resident(network.device());
  PanoramicSplit::Batch batch = split.begin(episodes);
  roll_out(network, batch.words, batch.walks, split.images(), options,
           [&](const PanoramicStep& step) {
             if (observer) observer(batch, step);
           });
  std::vector<tasks::Trajectory> trajectories(episodes.size());
  for (std::size_t row = 0; row < batch.walks.size(); ++row) {
    tasks::Trajectory& trajectory = trajectories[batch.places[row]];
    trajectory.episode = episodes[batch.places[row]];
    trajectory.points = batch.walks[row].trajectory();
  }
  return trajectories;
}

std::vector<tasks::Trajectory> rollout_and_write(PanoramicNetwork& network, PanoramicSplit& split,
                                                 const SplitRollout& options,
                                                 const Progress& progress) {
  return core::rollout_and_write<PanoramicRecording>(network, split, options, progress);
}

}  // namespace enfilade::neural::panoramic
