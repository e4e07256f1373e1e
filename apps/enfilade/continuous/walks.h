/// \file  The continuous benchmarks in the verbs `run` and `score`.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

#include "apps/common/program.h"

namespace enfilade::apps {

/// Options of `run`.
struct FreeWalk {
  std::string data, task, agent, split, features, output;
  std::string meshes = {};  ///< folder of them; empty: the data set's own
  bool walk_graph = false;  ///< the agent decides in the graph; its trajectories are followed
  std::uint64_t seed = 1;
  std::size_t batch_size = 64;
  int threads = 0;  ///< of drawing for a trained agent, 0: all cores
};
/// Runs an agent, writes its results and prints their scores.
void run_free_walk(const FreeWalk& walk);

/// Options of `score`.
struct FreeScore {
  std::string data, task, split, results, json;
  std::string scorer = {};  ///< empty: the default
  bool per_episode = false, part = false;
};
ExitCode score_free_walk(const FreeScore& score);

}  // namespace enfilade::apps
