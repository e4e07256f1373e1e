/// \file  An agent that follows the reference path.
#pragma once
#include <cstddef>
#include <string_view>
#include <vector>

#include "enfilade/agents/agent.h"

namespace enfilade::agents {

/// Follows the reference path, viewpoint by viewpoint, with the teacher's turns (shortest.h), then
/// stops with the true answer. Between viewpoints without an edge, which REVERIE, CVDN and SOON may
/// have, it takes the shortest path; if there is none it stops. Its score is that of the
/// annotators' own paths.
class ReferenceAgent : public Agent {
 public:
  std::string_view name() const override { return "reference"; }
  bool needs_goal() const override { return true; }
  void start(std::span<const Observation> batch) override;
  void act(std::span<const Observation> batch, std::span<Decision> decisions) override;

 private:
  std::vector<std::size_t> next_;  ///< by slot: index of the next viewpoint on the path
};

}  // namespace enfilade::agents
