#include "enfilade/neural/panoramic/panoramic_rollout.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"

namespace enfilade::neural::panoramic {
namespace {

using Clock = std::chrono::steady_clock;
using models::Feedback;

// What a step leaves for the losses.
struct Kept {
  at::Tensor hidden;           // of the LSTM
  at::Tensor log_chosen;       // (n) of the probability of the choice
  at::Tensor entropy;          // (n)
  at::Tensor active;           // (n) float
  std::ptrdiff_t actions = 0;  // how many are active
  std::vector<double> reward;
};

class Rollout {
 public:
  Rollout(PanoramicNetwork& network, std::span<PanoramicEpisode> walks, const ImageSource& images,
          const PanoramicRolloutOptions& options)
      : network_(network), walks_(walks), images_(images), options_(options) {
    for (std::size_t i = 0; i < walks.size(); ++i) {
      rngs_.emplace_back(options.seed, options.stream, i);
    }
  }

  RolloutLosses run(const WordBatch& words, const PanoramicObserver& observer) {
    const Encoding encoding = network_.encode(words);
    DecoderState state{encoding.start, encoding.cell};
    at::Tensor imitation = zero();
    for (std::size_t t = 0; t < options_.max_actions && going(); ++t) {
      const Clock::time_point begin = Clock::now();
      const StepInput input = seen();
      const std::vector<std::size_t> teachers = teachers_of();
      spent_ += Clock::now() - begin;
      const StepOutput out = network_.step(encoding, state, input);
      state = out.next;
      const at::Tensor logs = at::log_softmax(out.logits, 1);
      const std::vector<std::size_t> choices = choices_of(out.logits, teachers);
      if (options_.imitate) imitation = imitation - pick(logs, teachers).mul(active()).sum();
      if (options_.reinforce) keep(out, logs, choices);
      if (observer) observer({t, input, out, walks_, choices});
      const Clock::time_point moving = Clock::now();
      move(choices);
      spent_ += Clock::now() - moving;
      ++losses_.steps;
    }
    losses_.environment_seconds = std::chrono::duration<double>(spent_).count();
    if (options_.imitate) losses_.imitation = imitation / static_cast<double>(walks_.size());
    if (options_.reinforce) reinforce(encoding, state);
    return std::move(losses_);
  }

 private:
  StepInput seen() const {
    StepInput input = options_.resident != nullptr
                          ? look(walks_, network_.config(), *options_.resident)
                          : look(walks_, network_.config(), images_);
    input.dropped = options_.dropped;
    return input;
  }

  at::Tensor zero() const {
    return at::zeros({}, at::TensorOptions(at::kFloat).device(network_.device()));
  }

  // A number a row, on the network's device.
  at::Tensor row_tensor(const std::vector<double>& values) const {
    return at::tensor(values, at::kDouble).to(at::kFloat).to(network_.device());
  }

  bool going() const {
    return std::ranges::any_of(walks_, [](const PanoramicEpisode& walk) { return !walk.ended(); });
  }

  at::Tensor active() const {
    std::vector<double> active;
    for (const PanoramicEpisode& walk : walks_) active.push_back(walk.ended() ? 0 : 1);
    return row_tensor(active);
  }

  std::vector<std::size_t> teachers_of() const {
    std::vector<std::size_t> teachers(walks_.size(), 0);
    if (!options_.imitate && options_.feedback != Feedback::kTeacher) return teachers;
    for (std::size_t i = 0; i < walks_.size(); ++i) {
      if (!walks_[i].ended()) teachers[i] = walks_[i].teacher();
    }
    return teachers;
  }

  std::vector<std::size_t> choices_of(const at::Tensor& logits,
                                      const std::vector<std::size_t>& teachers) {
    if (options_.feedback == Feedback::kTeacher) return teachers;
    const at::Tensor values = logits.detach().to(at::kCPU, at::kFloat);
    const at::Tensor best = values.argmax(1);
    const at::Tensor shares = at::softmax(values, 1).contiguous();
    const bool draw = options_.feedback == Feedback::kSample && options_.draw == Draw::kRandom;
    std::vector<std::size_t> choices;
    for (std::size_t i = 0; i < walks_.size(); ++i) {
      const auto likeliest = best[static_cast<std::int64_t>(i)].item<std::int64_t>();
      const auto width = static_cast<std::size_t>(logits.size(1));
      const std::span<const float> row(shares.data_ptr<float>() + i * width, width);
      choices.push_back(draw && !walks_[i].ended() ? drawn(row, i)
                                                   : static_cast<std::size_t>(likeliest));
    }
    return choices;
  }

  std::size_t drawn(std::span<const float> shares, std::size_t row) {
    double left = rngs_[row].uniform();
    const std::size_t stop = walks_[row].stop();
    for (std::size_t k = 0; k < stop; ++k) {
      left -= static_cast<double>(shares[k]);
      if (left < 0) return k;
    }
    return stop;
  }

  at::Tensor pick(const at::Tensor& logs, const std::vector<std::size_t>& choices) const {
    const std::vector<std::int64_t> index(choices.begin(), choices.end());
    const at::Tensor there = at::tensor(index, at::kLong).to(network_.device());
    return logs.gather(1, there.unsqueeze(1)).squeeze(1);
  }

  void keep(const StepOutput& out, const at::Tensor& logs,
            const std::vector<std::size_t>& choices) {
    Kept kept;
    kept.hidden = out.hidden;
    kept.log_chosen = pick(logs, choices);
    // 0 where the probability is 0, and no gradient there.
    const at::Tensor finite = logs.masked_fill(out.logits.eq(-HUGE_VAL), 0);
    kept.entropy = -(logs.exp() * finite).sum(1);
    kept.active = active();
    kept.actions = std::ranges::count_if(walks_, [](const auto& walk) { return !walk.ended(); });
    kept_.push_back(std::move(kept));
  }

  void move(const std::vector<std::size_t>& choices) {
    std::vector<double> rewards(walks_.size(), 0);
    std::vector<std::uint8_t> acted(walks_.size(), 0);
    for (std::size_t i = 0; i < walks_.size(); ++i) {
      PanoramicEpisode& walk = walks_[i];
      if (walk.ended()) continue;
      acted[i] = 1;
      const float before = options_.reinforce ? static_cast<float>(walk.distance()) : 0;
      walk.choose(std::min(choices[i], walk.stop()));
      if (!options_.reinforce) continue;
      const auto after = static_cast<float>(walk.distance());
      if (walk.ended()) {
        rewards[i] = after < static_cast<float>(options_.success_distance) ? 2 : -2;
      } else {
        rewards[i] = after < before ? 1 : after > before ? -1 : 0;
      }
    }
    if (!options_.reinforce) return;
    kept_.back().reward = rewards;
    losses_.rewards.push_back(std::move(rewards));
    losses_.active.push_back(std::move(acted));
  }

  void reinforce(const Encoding& encoding, const DecoderState& state) {
    const at::Tensor last = last_values(encoding, state);
    losses_.last_values.assign(last.data_ptr<double>(), last.data_ptr<double>() + last.numel());
    std::vector<double> returns(walks_.size(), 0);
    for (std::size_t i = 0; i < walks_.size(); ++i) {
      if (!walks_[i].ended()) returns[i] = losses_.last_values[i];
    }
    losses_.returns.resize(kept_.size());
    losses_.values.resize(kept_.size());
    at::Tensor loss = zero();
    double actions = 0;
    std::vector<at::Tensor> values(kept_.size());
    for (std::size_t t = kept_.size(); t-- > 0;) {
      const Kept& kept = kept_[t];
      for (std::size_t i = 0; i < returns.size(); ++i) {
        returns[i] = returns[i] * options_.discount + kept.reward[i];
      }
      losses_.returns[t] = returns;
      const at::Tensor value = network_.value(kept.hidden);
      values[t] = value.detach();
      const at::Tensor error = row_tensor(returns) - value;
      const at::Tensor terms = -kept.log_chosen * error.detach() + 0.5 * error.square() -
                               options_.entropy * kept.entropy;
      loss = loss + (terms * kept.active).sum();
      actions += static_cast<double>(kept.actions);
    }
    for (std::size_t t = 0; t < values.size(); ++t) {
      const at::Tensor numbers = values[t].to(at::kCPU, at::kDouble).contiguous();
      losses_.values[t].assign(numbers.data_ptr<double>(),
                               numbers.data_ptr<double>() + numbers.numel());
    }
    losses_.reinforcement = loss / std::max(actions, 1.0);
  }

  // Values of one more step, without a gradient.
  at::Tensor last_values(const Encoding& encoding, const DecoderState& state) {
    const c10::NoGradGuard guard;
    const StepOutput out = network_.step(encoding, state, seen());
    return network_.value(out.hidden).to(at::kCPU, at::kDouble).contiguous();
  }

  PanoramicNetwork& network_;
  std::span<PanoramicEpisode> walks_;
  const ImageSource& images_;
  const PanoramicRolloutOptions& options_;
  std::vector<Rng> rngs_;
  std::vector<Kept> kept_;
  Clock::duration spent_{};
  RolloutLosses losses_;
};

}  // namespace

WordBatch batch_words(std::span<const std::vector<std::int64_t>> sentences) {
  WordBatch batch;
  std::size_t longest = 0;
  for (const auto& sentence : sentences) longest = std::max(longest, sentence.size());
  batch.ids = at::zeros({std::ssize(sentences), static_cast<std::int64_t>(longest)}, at::kLong);
  for (std::size_t i = 0; i < sentences.size(); ++i) {
    std::ranges::copy(sentences[i], batch.ids.data_ptr<std::int64_t>() + i * longest);
    batch.lengths.push_back(std::ssize(sentences[i]));
  }
  return batch;
}

RolloutLosses roll_out(PanoramicNetwork& network, const WordBatch& words,
                       std::span<PanoramicEpisode> walks, const ImageSource& images,
                       const PanoramicRolloutOptions& options, const PanoramicObserver& observer) {
  if (words.lengths.size() != walks.size()) {
    throw ArgumentError(
        fmt::format("words: {} sentences for {} walks", words.lengths.size(), walks.size()));
  }
  const bool goals = options.imitate || options.reinforce || options.feedback == Feedback::kTeacher;
  if (goals && !std::ranges::all_of(walks, &PanoramicEpisode::has_goal)) {
    throw ArgumentError("walks: one has no goal, which a teacher or a reward needs");
  }
  return Rollout(network, walks, images, options).run(words, observer);
}

}  // namespace enfilade::neural::panoramic
