#include "enfilade/neural/seq2seq/r2r_environment.h"

#include <fmt/format.h>

#include "enfilade/agents/shortest.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::neural::seq2seq {
namespace {

using models::AfterEnd;
using models::ForwardTo;

sim::SimulatorConfig simulator_config(const R2rEnvironmentConfig& config) {
  sim::SimulatorConfig simulator = sim::SimulatorConfig::room_to_room();
  simulator.batch_size = config.batch_size;  // which the simulator checks
  return simulator;
}

}  // namespace

R2rEnvironment::R2rEnvironment(const tasks::EpisodeSet& episodes,
                               const core::ViewFeatures* features,
                               const R2rEnvironmentConfig& config)
    : features_(features),
      config_(config),
      has_teacher_(!goals_hidden(episodes)),
      batch_(episodes, simulator_config(config), config.max_steps),
      actions_(config.batch_size) {
  if (config.forward == ForwardTo::kIntended && !has_teacher_) {
    throw ArgumentError(fmt::format(
        "forward to the intended neighbour: the goals of split {} are hidden", episodes.split));
  }
}

std::size_t R2rEnvironment::dimensions() const {
  return features_ == nullptr ? 0 : features_->dimensions();
}

void R2rEnvironment::start(std::span<const std::size_t> episodes) {
  batch_.begin(episodes);
  if (!has_teacher_) return;
  // The first use computes shortest paths, which would slow down a step.
  for (std::size_t i = 0; i < size(); ++i) (void)batch_.distance_to_goal(i);
}

void R2rEnvironment::observe(const EnvironmentView& out) {
  const sim::StateSpans& now = batch_.state();
  const std::size_t n = dimensions();
  for (std::size_t i = 0; i < size(); ++i) {
    if (n > 0) {
      features_->copy(now.scan[i], now.viewpoint[i], now.view_index[i],
                      out.features.subspan(i * n, n));
    }
    out.forward_open[i] = now.navigable_count[i] > 1 ? 1 : 0;
    if (!out.labels.empty()) out.labels[i] = label(i);
  }
}

bool R2rEnvironment::step(std::span<const std::int32_t> actions) {
  EN_CHECK_EQ(actions.size(), size());
  for (std::size_t i = 0; i < size(); ++i) {
    if (batch_.ended(i) && config_.after_end == AfterEnd::kStays) {
      actions_[i] = {};
      continue;
    }
    actions_[i] = action_of(i, actions[i]);
    if (actions[i] == static_cast<std::int32_t>(SixAction::kStop)) batch_.end(i);
  }
  batch_.step(actions_);
  return batch_.running() > 0;
}

agents::Decision R2rEnvironment::teacher(std::size_t slot) const {
  return agents::teacher_decision(batch_.observation(slot), batch_.path(slot).viewpoints.back());
}

std::int32_t R2rEnvironment::label(std::size_t slot) const {
  const bool ended = batch_.ended(slot);
  if (ended && config_.after_end == AfterEnd::kStays) return kIgnoreLabel;
  const SixAction action = six_action_of(teacher(slot));
  if (ended && action == SixAction::kStop) return kIgnoreLabel;
  return static_cast<std::int32_t>(action);
}

sim::Action R2rEnvironment::action_of(std::size_t slot, std::int32_t action) const {
  // Numbers that are no action leave the agent where it is, as `end` does.
  const bool known = action >= 0 && action < kSixActionCount;
  const auto one_of_six = known ? static_cast<SixAction>(action) : SixAction::kStop;
  const sim::Action done = to_action(one_of_six, batch_.state().navigable_count[slot]);
  if (done.index > 0 && config_.forward == ForwardTo::kIntended) {
    const agents::Decision decision = teacher(slot);
    if (decision.index > 0) return {decision.index, {}, {}};
  }
  return done;
}

}  // namespace enfilade::neural::seq2seq
