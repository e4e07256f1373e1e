#include "enfilade/neural/panoramic/panoramic_split.h"

#include <c10/core/GradMode.h>
#include <algorithm>
#include <numeric>
#include <utility>

#include "enfilade/neural/core/split_rollout.h"
#include "enfilade/neural/panoramic/recording.h"

namespace enfilade::neural::panoramic {

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
