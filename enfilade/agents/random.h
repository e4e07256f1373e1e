/// \file  The paper's Random agent.
#pragma once
#include <array>
#include <string_view>
#include <vector>

#include "enfilade/agents/agent.h"

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
  struct Plan {
    std::uint64_t turns = 0;  ///< of 30 degrees, still to make before the moves
    int moves = 0;            ///< still to make
    std::array<ViewpointIndex, kMoves + 1> walked = {};  ///< the first kMoves - moves + 1 of them
  };
  static Decision decide(const Observation& seen, Plan& plan);
  std::vector<Plan> plans_;  ///< by slot
};

}  // namespace enfilade::agents
