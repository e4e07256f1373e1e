/// \file  RxR: guides who speak while they walk, and followers who walk by what was said. Internal.
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
  std::vector<tasks::PoseTrace> traces;  ///< of the guides: where they stood and looked
};

/// Two guides, of India and of the United States: all that happens on the path, step by step, each
/// word with the time at which it is said; between two pieces the guide walks. Three out of four
/// followers walk the path, others turn back once, or stop a step early; their metrics are those of
/// the walk against the path. Traces have a snapshot at the beginning of each piece, and at each
/// step. Instruction ids are 10 times the path's id plus 1 and 2.
GuidedPath write_guides(const Site& site, const tasks::PathAnnotation& path, std::uint64_t seed);

}  // namespace enfilade::homes::benchmarks
