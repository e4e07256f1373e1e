// What the results' reader accepts of any benchmark, each of its scorers must take. The first byte
// says which benchmark.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/score_table.h"
#include "tests/fuzz/fixture.h"

namespace {

using namespace enfilade;
using tasks::Task;

tasks::NamedGoal goal_of(Task task) {
  if (task == Task::kR2rBack) return tasks::NamedTurningPoint{"v1"};
  if (task == Task::kReverie) return tasks::NamedObject{5};
  if (task == Task::kCvdn) return tasks::NamedRegion{"plant", {"v2"}, {"v0"}, {"v0", "v1"}};
  if (task != Task::kSoon) return tasks::NearEnd();
  tasks::NamedBox box{"v2", "vase", {}, {}};
  box.corners[1].heading = box.corners[2].heading = Radians(1);
  box.corners[2].elevation = box.corners[3].elevation = Radians(-1);
  return tasks::NamedBoxes{{box}, {}};
}

// Path 1 over v0 v1 v2 with instruction 1_0.
tasks::EpisodeSet episodes_of(Task task) {
  tasks::PathAnnotation path;
  path.path_id = 1;
  path.scan = "s";
  path.path = {"v0", "v1", "v2"};
  path.instructions = {"Walk."};
  path.goal = goal_of(task);
  if (task == Task::kSoon) path.details.emplace_back().fields = {{"instr_id", "7"}};
  tasks::Annotations annotations{"made", "<made>", {path}, task};
  tasks::ObjectBoxes boxes;
  tasks::ViewedObject object;
  object.id = 5;
  object.views = {0};
  object.boxes = {{1, 2, 3, 4}};
  boxes.add("s", "v2", {object});
  return make_episodes(annotations, fuzz::graphs(), tasks::Instructions::kScored, &boxes);
}

std::vector<tasks::EpisodeSet> all_episodes() {
  std::vector<tasks::EpisodeSet> all;
  for (std::uint8_t task = 0; task <= static_cast<std::uint8_t>(Task::kSoon); ++task) {
    all.push_back(episodes_of(static_cast<Task>(task)));
  }
  return all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto kEpisodes = all_episodes();
  if (size == 0) return 0;
  const auto& episodes = kEpisodes[data[0] % kEpisodes.size()];
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    const tasks::Results results = tasks::parse_results(text, "<fuzz>", episodes);
    for (const tasks::Scorer& scorer : tasks::benchmark(episodes.task).scorers) {
      const auto score = tasks::compute_score(results.trajectories, episodes, scorer,
                                              {.threads = 1, .bootstrap_samples = 10});
      EN_CHECK_EQ(score.means.size(), scorer.metrics.size());
      to_json(score, true);
    }
  } catch (const Error&) {
  }
  return 0;
}
