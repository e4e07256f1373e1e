#include "enfilade/neural/panoramic/panoramic_episode.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <algorithm>
#include <chrono>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "enfilade/core/rng.h"
#include "enfilade/models/decisions.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/neural/core/learner.h"

namespace enfilade::neural::panoramic {
namespace {

std::vector<float> first_of_row(const at::Tensor& values, std::size_t row, std::size_t count) {
  const at::Tensor one =
      values.select(0, static_cast<std::int64_t>(row)).to(at::kCPU, at::kFloat).contiguous();
  const float* data = one.data_ptr<float>();
  return {data, data + count};
}

// Records the steps of rollout_episodes(). One thread at a time.
class PanoramicRecording {
 public:
  // Of all episodes of a split.
  explicit PanoramicRecording(const PanoramicSplit& split)
      : recorder_(models::AgentKind::kPanoramic, split.episodes().episodes.size()) {
    for (std::size_t i = 0; i < split.episodes().episodes.size(); ++i) {
      std::vector<std::string> text;
      for (const std::int64_t id : split.words(i)) text.push_back(split.vocabulary().word(id));
      recorder_.read(i, std::move(text));
    }
  }
  const models::DecisionRecorder& recorder() const noexcept { return recorder_; }

  // An observer of a walk of these episodes, which have to stay as long as it is used.
  BatchObserver observer(std::span<const std::size_t> episodes) {
    return [this, episodes](const PanoramicSplit::Prepared& batch, const PanoramicStep& step) {
      for (std::size_t row = 0; row < step.walks.size(); ++row) {
        if (step.walks[row].ended()) continue;
        add(step, row, episodes[batch.places[row]],
            static_cast<std::size_t>(batch.words.lengths[row]));
      }
    };
  }

 private:
  void add(const PanoramicStep& step, std::size_t row, std::size_t episode, std::size_t words) {
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

  models::DecisionRecorder recorder_;
};

using Clock = std::chrono::steady_clock;
using models::Feedback;
using models::SampledLoss;

// Streams of random numbers of one part of a batch, so that no two draw the same.
enum Draws : std::uint64_t { kTeacherDropout, kOwnDropout, kOwnChoices, kStreams };

class PanoramicLearner : public core::SplitLearner<PanoramicNetwork, PanoramicSplit> {
 public:
  explicit PanoramicLearner(const core::LearnerParts& parts)
      : SplitLearner(
            parts, PanoramicNetwork(panoramic_sizes(parts.config), parts.config.seed, parts.device),
            {"encoder.", "decoder."}) {}

  core::Update update(std::uint64_t iteration) override {
    double data_seconds = 0;
    const double loss =
        learn(iteration, [&](const core::BatchPart& part) { return loss_of(part, data_seconds); });
    return {loss, data_seconds};
  }

  core::Evaluated evaluate(std::size_t split, std::uint64_t /*iteration*/,
                           const models::ModelFiles& files) override {
    return validated(split, validation_loss(split), network(), files);
  }

 private:
  at::Tensor loss_of(const core::BatchPart& part, double& data_seconds) {
    at::Tensor loss;
    const auto add = [&](PanoramicRolloutOptions options, Draws dropout, double weight) {
      options.resident = training().resident(network().device());
      const Clock::time_point begin = Clock::now();
      PanoramicSplit::Prepared walks = training().begin(part.episodes);
      data_seconds += std::chrono::duration<double>(Clock::now() - begin).count();
      network().set_dropout(Rng(config().seed, kStreams * part.stream + dropout, 1).next());
      const RolloutLosses losses =
          roll_out(network(), walks.words, walks.walks, training().images(), options);
      data_seconds += losses.environment_seconds;
      at::Tensor sum;
      if (options.imitate) sum = losses.imitation;
      if (options.reinforce) {
        sum = sum.defined() ? sum + losses.reinforcement : losses.reinforcement;
      }
      loss = loss.defined() ? loss + weight * sum : weight * sum;
    };
    const bool alone = config().feedback == Feedback::kTeacher;
    if (alone || config().teacher_weight > 0) {
      add(behind_teacher(), kTeacherDropout, alone ? 1 : config().teacher_weight);
    }
    if (!alone) add(on_its_own(part.stream), kOwnDropout, 1);
    return loss;
  }

  // Behind the teacher, without dropout.
  double validation_loss(std::size_t split) {
    const c10::NoGradGuard no_gradients;
    network().set_dropout(std::nullopt);
    PanoramicSplit& prepared = validation(split);
    PanoramicRolloutOptions options = behind_teacher();
    options.resident = prepared.resident(network().device());
    return core::mean_of_batches(ranks(), prepared.episodes().episodes.size(), config().batch_size,
                                 [&](std::span<const std::size_t> episodes) {
                                   PanoramicSplit::Prepared walks = prepared.begin(episodes);
                                   return roll_out(network(), walks.words, walks.walks,
                                                   prepared.images(), options)
                                              .imitation.item<double>() *
                                          static_cast<double>(episodes.size());
                                 });
  }

  PanoramicRolloutOptions behind_teacher() const {
    return {.feedback = Feedback::kTeacher, .max_actions = config().max_steps, .imitate = true};
  }

  PanoramicRolloutOptions on_its_own(std::uint64_t stream) const {
    return {.feedback = Feedback::kSample,
            .max_actions = config().max_steps,
            .imitate = config().sampled_loss == SampledLoss::kLabels,
            .reinforce = config().sampled_loss == SampledLoss::kReinforce,
            .seed = config().seed,
            .stream = kStreams * stream + kOwnChoices};
  }
};

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

PanoramicSplit::Prepared PanoramicSplit::begin(std::span<const std::size_t> episodes) {
  Prepared batch;
  batch.places.resize(episodes.size());
  std::iota(batch.places.begin(), batch.places.end(), std::size_t{0});
  std::ranges::stable_sort(batch.places, std::ranges::greater{},
                           [&](std::size_t place) { return words_[episodes[place]].size(); });
  std::vector<std::vector<std::int64_t>> sentences;
  for (const std::size_t place : batch.places) {
    const std::size_t index = episodes[place];
    sentences.push_back(words_[index]);
    const tasks::ReferencePath& path = episodes_.path_of(episodes_.episodes[index]);
    ListenerStart start{{path.scan, path.viewpoints.front()}, path.heading, std::nullopt};
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
  PanoramicSplit::Prepared batch = split.begin(episodes);
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

namespace enfilade::neural::core {

std::unique_ptr<Learner> make_panoramic_learner(const LearnerParts& parts) {
  return std::make_unique<panoramic::PanoramicLearner>(parts);
}

}  // namespace enfilade::neural::core
