/// \file  The paper's Shortest agent, which is also the teacher of the sequence-to-sequence one.
#pragma once
#include <optional>
#include <string_view>
#include <vector>

#include "enfilade/agents/agent.h"
#include "enfilade/tasks/goal_distance.h"

namespace enfilade::agents {

/// What the teacher of the released R2R code does at this observation on the way to the goal
/// (docs/agents.md has the rules): the next viewpoint of the shortest path is walked to if it is
/// navigable and within 30 degrees of the view's middle, turned to otherwise; stops at the goal.
/// An oracle: looks at the graph. Also stops where the goal is out of reach.
Decision teacher_decision(const Observation& seen, ViewpointIndex goal);

/// What is true at the end of an episode, by its goal: R2R-Back's turning point; REVERIE's object,
/// seen from here or not; SOON's, the middle of the box of this viewpoint, of several the last, as
/// DUET's scorer takes it, and no point where there is none. Nothing for other goals. An oracle.
Answer true_answer(const Observation& seen);

/// Follows the teacher: always takes the shortest path to the nearest viewpoint that satisfies the
/// goal (tasks/goal_distance.h), of R2R-Back to the turning point and from there to the end; then
/// stops with the true answer.
class ShortestAgent : public Agent {
 public:
  std::string_view name() const override { return "shortest"; }
  bool needs_goal() const override { return true; }
  void start(std::span<const Observation> batch) override;
  void act(std::span<const Observation> batch, std::span<Decision> decisions) override;

 private:
  struct Plan {
    tasks::Leg leg = tasks::Leg::kOut;
    std::optional<ViewpointIndex> target;  // none: out of reach
  };
  static Decision decide(const Observation& seen, Plan& plan);
  std::vector<Plan> plans_;  ///< by slot
};

}  // namespace enfilade::agents
