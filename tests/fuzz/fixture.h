/// \file  A small graph and episodes on it, for fuzzing what refers to them.
#pragma once
#include <memory>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/annotations.h"
#include "tests/support/graphs.h"

namespace enfilade::fuzz {

inline std::shared_ptr<const graph::GraphSet> graphs() {
  std::vector<graph::NavGraph> all;
  all.emplace_back(graph::testing::square("s"));
  return graph::GraphSet::of(std::move(all));
}

/// Path 1 over v0 v1 v2 with instructions 1_0 and 1_1.
inline tasks::EpisodeSet episodes() {
  return tasks::make_episodes(
      tasks::parse_annotations(R"([{"path_id": 1, "scan": "s", "heading": 0.5,
          "path": ["v0", "v1", "v2"], "instructions": ["Walk.", "Stop."]}])",
                               "<made>", "made"),
      graphs());
}

}  // namespace enfilade::fuzz
