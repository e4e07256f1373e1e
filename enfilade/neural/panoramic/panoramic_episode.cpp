#include "enfilade/neural/panoramic/panoramic_episode.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <tuple>
#include <utility>

#include "enfilade/agents/experts.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"

namespace enfilade::neural::panoramic {
namespace {

constexpr std::uint32_t kViews = 36;

// [sin h, cos h, sin e, cos e], repeated.
void write_angle(Radians heading, Radians elevation, std::span<float> out) {
  const agents::AngleFeature numbers = agents::angle_feature(heading, elevation);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = numbers[i % numbers.size()];
}

std::span<float> row_of(const at::Tensor& tensor, std::size_t row, std::size_t width) {
  return {tensor.data_ptr<float>() + row * width, width};
}

// The four numbers again and again, as write_angle() has them.
at::Tensor repeated(const at::Tensor& angles, std::int64_t columns) {
  const std::int64_t four = angles.size(2);
  return angles.repeat({1, 1, (columns + four - 1) / four}).narrow(2, 0, columns);
}

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

PanoramicEpisode::PanoramicEpisode(agents::PanoramaCache& panoramas, const graph::GraphSet& graphs,
                                   const ListenerStart& start)
    : panoramas_(&panoramas),
      graphs_(&graphs),
      location_(start.location),
      view_(agents::level_view(start.heading)),
      goal_(start.goal) {
  arrive();
}

Radians PanoramicEpisode::heading() const noexcept { return agents::view_heading(view_); }
Radians PanoramicEpisode::elevation() const noexcept { return agents::view_elevation(view_); }

void PanoramicEpisode::add_point() {
  points_.push_back({location_.viewpoint, heading(), elevation()});
}

void PanoramicEpisode::arrive() {
  candidates_ = &panoramas_->at(location_).candidates;
  add_point();
}

double PanoramicEpisode::distance() const {
  EN_CHECK(goal_.has_value());
  return graphs_->graph(location_.scan).distance(location_.viewpoint, *goal_);
}

std::size_t PanoramicEpisode::teacher() const {
  EN_CHECK(goal_.has_value());
  const auto next =
      agents::next_on_shortest(graphs_->graph(location_.scan), location_.viewpoint, *goal_);
  if (!next || *next == location_.viewpoint) return stop();
  const auto chosen = std::ranges::find(*candidates_, *next, &sim::Candidate::viewpoint);
  return static_cast<std::size_t>(chosen - candidates_->begin());
}

void PanoramicEpisode::choose(std::size_t choice) {
  EN_CHECK(!ended_);
  EN_CHECK_LE(choice, stop());
  if (choice == stop()) {
    ended_ = true;
    return;
  }
  const sim::Candidate& chosen = (*candidates_)[choice];
  for (;;) {
    const sim::Action action = agents::step_towards(chosen, view_);
    if (action.index != 0) break;
    view_ = agents::view_after(action, view_);
    add_point();
  }
  location_.viewpoint = chosen.viewpoint;
  arrive();
}

ImageSource pictures_of(const core::ViewFeatures* features) {
  return [features](graph::Location location, std::uint32_t view, std::span<float> out) {
    if (features != nullptr) features->copy(location.scan, location.viewpoint, view, out);
  };
}

StepInput look(std::span<const PanoramicEpisode> walks, const PanoramicConfig& config,
               const ImageSource& images) {
  std::size_t most = 0;
  for (const PanoramicEpisode& walk : walks) most = std::max(most, walk.stop() + 1);
  const auto n = static_cast<std::int64_t>(walks.size());
  const auto slots = static_cast<std::int64_t>(most);
  const std::size_t width = config.feature();
  const auto wide = static_cast<std::int64_t>(width);
  StepInput input;
  input.action = at::empty({n, static_cast<std::int64_t>(config.angle)}, at::kFloat);
  input.views = at::empty({n, kViews, wide}, at::kFloat);
  input.candidates = at::zeros({n, slots, wide}, at::kFloat);
  input.closed = at::zeros({n, slots}, at::kBool);
  for (std::size_t i = 0; i < walks.size(); ++i) {
    const PanoramicEpisode& walk = walks[i];
    const Radians base = walk.heading();
    write_angle(base, walk.elevation(), row_of(input.action, i, config.angle));
    for (std::uint32_t view = 0; view < kViews; ++view) {
      const auto out = row_of(input.views, i * kViews + view, width);
      images(walk.location(), view, out.first(config.image));
      write_angle(agents::view_heading(view) - base, agents::view_elevation(view),
                  out.subspan(config.image));
    }
    for (std::size_t k = 0; k < walk.stop(); ++k) {
      const sim::Candidate& candidate = walk.candidates()[k];
      const auto out = row_of(input.candidates, i * most + k, width);
      const auto picture = row_of(input.views, i * kViews + candidate.view, width);
      std::ranges::copy(picture.first(config.image), out.begin());
      write_angle(candidate.heading - base, candidate.elevation, out.subspan(config.image));
    }
    bool* const closed = input.closed.data_ptr<bool>() + i * most;
    std::fill(closed + walk.stop() + 1, closed + most, true);
  }
  return input;
}

StepInput look(std::span<const PanoramicEpisode> walks, const PanoramicConfig& config,
               core::ResidentViews& images) {
  PanoramicConfig blind = config;
  blind.image = 0;
  blind.angle = std::tuple_size_v<agents::AngleFeature>;
  const StepInput seen =
      look(walks, blind, ImageSource([](graph::Location, std::uint32_t, std::span<float>) {}));
  const std::int64_t n = seen.views.size(0), most = seen.candidates.size(1);
  std::vector<std::int64_t> rows;  // of the views, then of the candidates
  for (const PanoramicEpisode& walk : walks) {
    const std::int64_t first = images.first_row(walk.location());
    for (std::uint32_t view = 0; view < kViews; ++view) rows.push_back(first + view);
  }
  for (const PanoramicEpisode& walk : walks) {
    const std::int64_t first = images.first_row(walk.location());
    for (std::int64_t k = 0; k < most; ++k) {
      const auto at = static_cast<std::size_t>(k);
      rows.push_back(at < walk.stop() ? first + walk.candidates()[at].view
                                      : core::ResidentViews::kNothing);
    }
  }
  const at::Tensor pictures = images.gather(rows);
  const c10::Device device = pictures.device();
  const auto angle = static_cast<std::int64_t>(config.angle);
  const auto together = [&](const at::Tensor& part, const at::Tensor& angles) {
    return at::cat(
        {part.view({n, angles.size(1), part.size(1)}), repeated(angles.to(device), angle)}, 2);
  };
  StepInput input;
  input.action = repeated(seen.action.unsqueeze(1), angle).squeeze(1).to(device);
  input.views = together(pictures.narrow(0, 0, n * kViews), seen.views);
  input.candidates = together(pictures.narrow(0, n * kViews, n * most), seen.candidates);
  input.closed = seen.closed.to(device);
  return input;
}

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
