/// \file  A small world for sessions: nine viewpoints, and episodes in it. SYNTHETIC.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/objects.h"
#include "tests/support/graphs.h"

namespace enfilade::arena::testing {

/// v0 v1 v4 with the instruction "Go to the desk."; of REVERIE v1 sees the desk, object 7; of
/// R2R-Back the way leads to v4 and back to v0. Then
/// `more` paths of other starts, two steps long.
inline std::shared_ptr<const tasks::EpisodeSet> episodes(tasks::Task task = tasks::Task::kR2r,
                                                         std::int64_t more = 0) {
  tasks::Annotations annotations{"test", "", {}};
  annotations.task = task;
  tasks::PathAnnotation path{1, "grid", Radians(0.1), {"v0", "v1", "v4"}, 8.0, {"Go to the desk."}};
  auto boxes = std::make_shared<tasks::ObjectBoxes>();
  if (task == tasks::Task::kReverie) {
    path.id = "1";
    path.goal = tasks::NamedObject{7};
    tasks::ViewedObject desk{7, "desk#oak", {15}, {{305, 225, 30, 30}}};  // east, level, the middle
    tasks::ViewedObject hidden{8, "lamp", {}, {}};
    boxes->add("grid", "v1", {hidden, desk});
  }
  if (task == tasks::Task::kR2rBack) {
    path.path = {"v0", "v1", "v4", "v1", "v0"};
    path.goal = tasks::NamedTurningPoint{"v4"};
  }
  annotations.paths.push_back(path);
  const std::vector<std::vector<std::string>> others{
      {"v8", "v7", "v6"}, {"v2", "v5", "v8"}, {"v6", "v3", "v4"}, {"v4", "v1", "v2"}};
  for (std::int64_t k = 0; k < more; ++k) {
    tasks::PathAnnotation one = path;
    one.path_id = 2 + k;
    if (task == tasks::Task::kReverie) one.id = std::to_string(2 + k);
    one.path = others[static_cast<std::size_t>(k) % others.size()];
    one.heading = Radians(0.7 * static_cast<double>(k));
    one.instructions = {"Walk two steps, " + std::to_string(k) + ".",
                        "Go on, " + std::to_string(k) + "."};
    annotations.paths.push_back(one);
  }
  auto made = tasks::make_episodes(annotations, graph::testing::grid(),
                                   tasks::Instructions::kScored, boxes.get());
  if (task == tasks::Task::kReverie) made.objects = boxes;
  return std::make_shared<const tasks::EpisodeSet>(std::move(made));
}

}  // namespace enfilade::arena::testing
