/// \file  For tests: checks whether an instruction is true. Shares only the home with the code
/// that wrote it.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/home.h"
#include "enfilade/mesh/ray_tracer.h"
#include "tests/support/instructions/route.h"

namespace enfilade::homes::instructions::testing {

/// Reads the text clause by clause and follows the path by it. Checks turns, sides of objects,
/// rooms, doors and stairs in the order met, and the end. Objects must be in view, by rays of its
/// own to their boxes. Does not use Sights.
class InstructionChecker {
 public:
  InstructionChecker(const Home& home, const mesh::RayTracer& tracer, const graph::NavGraph& graph)
      : home_(home), tracer_(tracer), graph_(graph), surfaces_(home.mesh) {}

  /// The faults; empty if all of it is true.
  std::vector<std::string> check(const std::string& text, std::span<const ViewpointIndex> path,
                                 double heading) const;

 private:
  const Home& home_;
  const mesh::RayTracer& tracer_;
  const graph::NavGraph& graph_;
  Surfaces surfaces_;
};

}  // namespace enfilade::homes::instructions::testing
