/// \file  The paper's Shortest agent, which is also the teacher of the sequence-to-sequence one.
#pragma once
#include <optional>
#include <string_view>
#include <vector>

#include "enfilade/agents/agent.h"
#include "enfilade/tasks/goal_distance.h"

namespace enfilade::agents {

/// The decision of the released R2R code's teacher at this observation, towards the goal
/// (docs/agents.md has the rules). It goes to the next viewpoint of the shortest path if that is
/// navigable and within 30 degrees of the view's middle. Otherwise it turns to it. It stops at the
/// goal. An oracle: uses the graph. Also stops if the goal is out of reach.
Decision teacher_decision(const Observation& seen, ViewpointIndex goal);

/// The true answer at the end of an episode, by its goal. R2R-Back's turning point. REVERIE's
/// object, seen from here or not. SOON's: the middle of this viewpoint's box (the last of several,
/// as DUET's scorer takes it), and no point without a box. Empty for other goals. An oracle.
Answer true_answer(const Observation& seen);

/// Follows the teacher: always takes the shortest path to the nearest viewpoint that satisfies the
/// goal (tasks/goal_distance.h). In R2R-Back, to the turning point and from there to the end. Then
/// it stops with the true answer.
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
