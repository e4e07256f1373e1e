/// \file  RxR: guides who speak along a path, and followers of their instructions. Internal.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/homes/benchmarks/site.h"
#include "enfilade/tasks/demonstrations.h"
#include "enfilade/tasks/pose_trace.h"

namespace enfilade::homes::benchmarks {

/// The guides of a path, and a follower of each.
struct GuidedPath {
  std::vector<tasks::PathAnnotation> guides;  ///< one instruction each
  std::vector<tasks::Demonstration> walks;
  std::vector<tasks::PoseTrace> traces;  ///< poses of the guides
};

/// Two guides, of India and of the United States. Each describes every event of the path, step by
/// step, with the time of each word; between two pieces the guide moves on. Three out of four
/// followers take the path, others turn back once, or stop a step early. Their metrics are those of
/// their trajectory against the path. Traces have a snapshot at the beginning of each piece, and at
/// each step. Instruction ids are 10 times the path's id plus 1 and 2.
GuidedPath write_guides(const Site& site, const tasks::PathAnnotation& path, std::uint64_t seed);

}  // namespace enfilade::homes::benchmarks
