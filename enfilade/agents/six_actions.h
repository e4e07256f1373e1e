/// \file  The six low-level actions of the paper's agent.
#pragma once
#include <cstdint>
#include <string_view>

#include "enfilade/agents/agent.h"
#include "enfilade/sim/simulator.h"

namespace enfilade::agents {

/// Anderson et al. 2018, section 4.2, in the order of the released network's outputs. A turn is one
/// view of 30 degrees.
enum class SixAction : std::int32_t { kLeft, kRight, kUp, kDown, kForward, kStop };
/// How many SixActions there are.
inline constexpr std::int32_t kSixActionCount = 6;

/// "left", "right", "up", "down", "forward", "end" (the released code's word for stop).
std::string_view to_string(SixAction action) noexcept;

/// The action of a simulator with discretized viewing. Forward leads to entry 1 of the navigable
/// list, the viewpoint nearest to the middle of the view; without one, and for kStop, the agent
/// stays.
/// \param navigable_count of the agent, its own viewpoint included
sim::Action to_action(SixAction action, std::uint32_t navigable_count) noexcept;

/// The same as a decision: to_action(), and whether to stop for good.
Decision to_decision(SixAction action, std::uint32_t navigable_count) noexcept;

/// The one of the six that a decision is: a turn, forward (to any entry of the list), or stop.
SixAction six_action_of(const Decision& decision) noexcept;

}  // namespace enfilade::agents
