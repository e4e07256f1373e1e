#include "enfilade/agents/six_actions.h"

#include <array>

namespace enfilade::agents {

std::string_view to_string(SixAction action) noexcept {
  constexpr std::array<std::string_view, kSixActionCount> kNames{"left", "right",   "up",
                                                                 "down", "forward", "end"};
  return kNames[static_cast<std::size_t>(action)];
}

sim::Action to_action(SixAction action, std::uint32_t navigable_count) noexcept {
  // Only the sign of a change counts.
  constexpr std::array<sim::Action, kSixActionCount> kActions{{{0, Radians(-1), {}},
                                                               {0, Radians(1), {}},
                                                               {0, {}, Radians(1)},
                                                               {0, {}, Radians(-1)},
                                                               {1, {}, {}},
                                                               {}}};
  sim::Action done = kActions[static_cast<std::size_t>(action)];
  if (done.index >= navigable_count) done.index = 0;
  return done;
}

Decision to_decision(SixAction action, std::uint32_t navigable_count) noexcept {
  const sim::Action done = to_action(action, navigable_count);
  return {action == SixAction::kStop, done.index, done.heading_change, done.elevation_change};
}

SixAction six_action_of(const Decision& decision) noexcept {
  if (decision.heading_change.value > 0) return SixAction::kRight;
  if (decision.heading_change.value < 0) return SixAction::kLeft;
  if (decision.elevation_change.value > 0) return SixAction::kUp;
  if (decision.elevation_change.value < 0) return SixAction::kDown;
  return decision.index > 0 ? SixAction::kForward : SixAction::kStop;
}

}  // namespace enfilade::agents
