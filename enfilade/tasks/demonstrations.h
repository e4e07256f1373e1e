/// \file  Trajectories of people who followed instructions (RxR's followers).
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace enfilade::tasks {

/// A follower's trajectory for one instruction, with the scores of the data set's authors.
struct Demonstration {
  std::int64_t demonstration_id = 0, instruction_id = 0, annotator_id = 0;
  std::vector<std::string> path;
  /// Metres (dtw is not normalised), shares. Against the guide's path of the instruction. Published
  /// ones cannot be reproduced exactly from connectivity files: docs/tasks.md.
  double ne = 0, sr = 0, spl = 0, dtw = 0, ndtw = 0, sdtw = 0;
  friend bool operator==(const Demonstration&, const Demonstration&) = default;
};

}  // namespace enfilade::tasks
