#include "enfilade/neural/continuous/gatherer.h"

#include <ATen/ATen.h>

namespace enfilade::neural::continuous {

using enfilade::continuous::Action;

namespace {

// A choice by probabilities, or the likeliest.
std::int64_t choose(const float* probabilities, bool drawn, Rng& rng) {
  const double at = drawn ? rng.uniform() : 0;
  double sum = 0;
  std::int64_t best = 0;
  for (std::int64_t c = 0; c < kChoices; ++c) {
    sum += static_cast<double>(probabilities[c]);
    if (drawn && at < sum) return c;
    if (probabilities[c] > probabilities[best]) best = c;
  }
  return best;  // not drawn, or the rest that rounding leaves
}

// The part of one row.
template <class T>
void append_row(std::vector<T>& all, const std::vector<T>& rows, std::size_t row, std::size_t n) {
  const std::size_t width = rows.size() / n;
  const auto first = rows.begin() + static_cast<std::ptrdiff_t>(row * width);
  all.insert(all.end(), first, first + static_cast<std::ptrdiff_t>(width));
}

}  // namespace

std::vector<std::size_t> walking(std::span<const agents::ContinuousObservation> batch) {
  std::vector<std::size_t> slots;
  for (std::size_t s = 0; s < batch.size(); ++s) {
    if (!batch[s].ended) slots.push_back(s);
  }
  return slots;
}

Gatherer::Gatherer(const GathererParts& parts, const Mixture& mixture,
                   const tasks::ContinuousEpisodes& episodes)
    : parts_(parts),
      mixture_(mixture),
      episodes_(episodes),
      teacher_(agents::make_patient_reference()),
      states_(*parts.network),
      walks_(episodes.episodes.size()) {}

void Gatherer::start(std::size_t slot, const agents::ContinuousObservation& seen,
                     const enfilade::continuous::SimulatorConfig& config) {
  teacher_->start(slot, seen, config);
  states_.start(slot, read_text(*parts_.words, seen.episode->instruction.text, *parts_.config));
  eye_height_ = config.eye_height;
}

void Gatherer::act(std::span<const agents::ContinuousObservation> batch,
                   std::span<Action> actions) {
  teacher_->act(batch, actions);
  const std::vector<std::size_t> slots = walking(batch);
  const Seen seen =
      parts_.sight != nullptr ? parts_.sight->look(batch, slots, eye_height_) : Seen{};
  const bool teacher_alone = mixture_.teacher_share >= 1;
  const at::Tensor probabilities = teacher_alone ? at::Tensor() : states_.step(slots, seen);
  for (std::size_t k = 0; k < slots.size(); ++k) {
    const std::size_t slot = slots[k];
    const agents::ContinuousObservation& own = batch[slot];
    const auto advice = static_cast<std::int64_t>(actions[slot]);
    std::int64_t choice = advice;
    if (!teacher_alone && own.rng->uniform() >= mixture_.teacher_share) {
      const bool last = own.step + 1 == mixture_.last_action;
      choice =
          last ? 0
               : choose(probabilities.data_ptr<float>() + static_cast<std::int64_t>(k) * kChoices,
                        mixture_.drawn, *own.rng);
    }
    RecordedEpisode& walk =
        walks_[static_cast<std::size_t>(own.episode - episodes_.episodes.data())];
    append_row(walk.seen.pictures, seen.pictures, k, slots.size());
    append_row(walk.seen.depth, seen.depth, k, slots.size());
    walk.previous.push_back(static_cast<std::uint8_t>(states_.previous(slot)));
    walk.teacher.push_back(static_cast<std::uint8_t>(advice));
    states_.tell(slot, choice);
    actions[slot] = static_cast<Action>(choice);
  }
}

}  // namespace enfilade::neural::continuous
