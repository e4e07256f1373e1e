/// \file  The paper's Random agent.
#pragma once
#include <string_view>
#include <vector>

#include "enfilade/agents/agent.h"

namespace enfilade::agents {

/// Turns to a random heading, then makes five moves, each to the viewpoint nearest to the middle of
/// its view; turns right where nothing is ahead (the paper, section 5.3).
class RandomAgent : public Agent {
 public:
  static constexpr int kMoves = 5;  ///< the paper's; R2R's paths have four to six

  std::string_view name() const override { return "random"; }
  void start(std::span<const Observation> batch) override;
  void act(std::span<const Observation> batch, std::span<Decision> decisions) override;

 private:
  struct Plan {
    std::uint64_t turns = 0;  ///< of 30 degrees, still to make before walking
    int moves = 0;            ///< still to make
  };
  std::vector<Plan> plans_;  ///< by slot
};

}  // namespace enfilade::agents
