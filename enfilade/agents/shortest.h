/// \file  The paper's Shortest agent, which is also the teacher of the sequence-to-sequence one.
#pragma once
#include <string_view>

#include "enfilade/agents/agent.h"

namespace enfilade::agents {

/// What the teacher of the released R2R code does at this observation on the way to the goal
/// (docs/agents.md has the rules): the next viewpoint of the shortest path is walked to if it is
/// navigable and within 30 degrees of the view's middle, turned to otherwise; stops at the goal.
/// An oracle: looks at the graph. Also stops where the goal is out of reach.
Decision teacher_decision(const Observation& seen, ViewpointIndex goal);

/// Follows the teacher: always takes the shortest path to the goal.
class ShortestAgent : public Agent {
 public:
  std::string_view name() const override { return "shortest"; }
  bool needs_goal() const override { return true; }
  void start(std::span<const Observation>) override {}
  void act(std::span<const Observation> batch, std::span<Decision> decisions) override;
};

}  // namespace enfilade::agents
