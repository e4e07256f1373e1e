/// \file  Agents that learn nothing: random, reference and shortest.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "enfilade/agents/agent.h"
#include "enfilade/tasks/goal_distance.h"

namespace enfilade::agents {

/// Turns to a random heading, then makes five moves, each to the viewpoint nearest to the middle of
/// its view. Turns right if none is ahead (the paper, section 5.3). Draws an answer at the end if
/// the benchmark requires one:
/// - R2R-Back: one of the viewpoints of its trajectory
/// - REVERIE: one of the objects that are seen there, if the episodes have objects
/// - SOON: a direction
///
/// These draws come after all others, so that they change no trajectory.
class RandomAgent : public Agent {
 public:
  static constexpr int kMoves = 5;  ///< the paper's; R2R's paths have four to six

  std::string_view name() const override { return "random"; }
  void start(std::span<const Observation> batch) override;
  void act(std::span<const Observation> batch, std::span<Decision> decisions) override;

 private:
  struct Draw {
    std::uint64_t turns = 0;  ///< of 30 degrees, still to make before the moves
    int moves = 0;            ///< still to make
    std::array<ViewpointIndex, kMoves + 1> walked = {};  ///< the first kMoves - moves + 1 of them
  };
  static Decision decide(const Observation& seen, Draw& plan);
  std::vector<Draw> plans_;  ///< by slot
};

/// Follows the reference path, viewpoint by viewpoint, with the teacher's turns
/// (teacher_decision()), then stops with the true answer. Between viewpoints without an edge, which
/// REVERIE, CVDN and SOON may have, it takes the shortest path; if there is none it stops. Its
/// score is that of the annotators' own paths.
class ReferenceAgent : public Agent {
 public:
  std::string_view name() const override { return "reference"; }
  bool needs_goal() const override { return true; }
  void start(std::span<const Observation> batch) override;
  void act(std::span<const Observation> batch, std::span<Decision> decisions) override;

 private:
  std::vector<std::size_t> next_;  ///< by slot: index of the next viewpoint on the path
};

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
  struct Target {
    tasks::Leg leg = tasks::Leg::kOut;
    std::optional<ViewpointIndex> target;  // none: out of reach
  };
  static Decision decide(const Observation& seen, Target& plan);
  std::vector<Target> plans_;  ///< by slot
};

}  // namespace enfilade::agents
