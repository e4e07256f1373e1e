/// \file  A small graph and episodes on it, for fuzzing what refers to them.
#pragma once
#include <memory>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/objects.h"
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

inline tasks::NamedGoal goal_of(tasks::Task task) {
  if (task == tasks::Task::kR2rBack) return tasks::NamedTurningPoint{"v1"};
  if (task == tasks::Task::kReverie) return tasks::NamedObject{5};
  if (task == tasks::Task::kCvdn) return tasks::NamedRegion{"plant", {"v2"}, {"v0"}, {"v0", "v1"}};
  if (task != tasks::Task::kSoon) return tasks::NearEnd();
  tasks::NamedBox box{"v2", "vase", {}, {}};
  box.corners[1].heading = box.corners[2].heading = Radians(1);
  box.corners[2].elevation = box.corners[3].elevation = Radians(-1);
  return tasks::NamedBoxes{{box}, {}};
}

/// The same path with instruction 1_0, of any benchmark on graphs.
inline tasks::EpisodeSet episodes_of(tasks::Task task) {
  tasks::PathAnnotation path;
  path.path_id = 1;
  path.scan = "s";
  path.path = {"v0", "v1", "v2"};
  path.instructions = {"Walk."};
  path.goal = goal_of(task);
  if (task == tasks::Task::kSoon) path.details.emplace_back().fields = {{"instr_id", "7"}};
  tasks::Annotations annotations{"made", "<made>", {path}, task};
  tasks::ObjectBoxes boxes;
  tasks::ViewedObject object;
  object.id = 5;
  object.views = {0};
  object.boxes = {{1, 2, 3, 4}};
  boxes.add("s", "v2", {object});
  return make_episodes(annotations, graphs(), tasks::Instructions::kScored, &boxes);
}

}  // namespace enfilade::fuzz
