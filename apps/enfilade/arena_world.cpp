#include "apps/enfilade/arena_world.h"

#include <map>
#include <mutex>
#include <utility>

#include "apps/common/program.h"
#include "apps/enfilade/mesh_files.h"
#include "apps/enfilade/task_option.h"
#include "enfilade/tasks/split.h"

namespace enfilade::apps {
namespace {

/// Opens each building once, for as long as a user of it lives.
class SharedScenes {
 public:
  explicit SharedScenes(std::shared_ptr<const dataset::Dataset> data) : data_(std::move(data)) {}

  std::shared_ptr<const continuous::Scene> at(const std::string& scan) {
    const std::scoped_lock lock(mutex_);
    std::weak_ptr<const continuous::Scene>& known = known_[scan];
    auto scene = known.lock();
    if (!scene) known = scene = scene_of_scan(*data_, {}, scan, 0);
    return scene;
  }

 private:
  std::shared_ptr<const dataset::Dataset> data_;
  std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const continuous::Scene>> known_;
};

}  // namespace

OpenedWorld open_world(const std::shared_ptr<const dataset::Dataset>& data, const std::string& task,
                       const std::string& split, const WordsMaker& words) {
  OpenedWorld opened;
  const auto words_from = [&words](const arena::ViewSources& sights) {
    return words ? words(sights) : arena::WordsSource();
  };
  const tasks::Benchmark& benchmark = benchmark_of(task, *data);
  opened.title = benchmark.title;
  tasks::Split episodes = data->split(benchmark, split, {.experts = false});
  if (benchmark.continuous()) {
    opened.sights.scene_of = [scenes = std::make_shared<SharedScenes>(data)](
                                 const std::string& scan) { return scenes->at(scan); };
    opened.world = std::make_unique<arena::FloorWorld>(std::move(episodes), data->folder(),
                                                       words_from(opened.sights));
    return opened;
  }
  opened.sights.data = data;
  opened.world =
      std::make_unique<arena::GraphWorld>(episodes.on_graph(), words_from(opened.sights));
  return opened;
}

void add_subset_option(CLI::App& verb, std::string& subset) {
  add_value(verb, "--subset", subset, "N|FILE|all",
            "N episodes, spread over buildings and lengths; file of ids; all "
            "(default: 100, or as many as there are)");
}

void add_steps_option(CLI::App& verb, std::uint32_t& steps) {
  add_whole_number(verb, "--steps", steps,
                   "Most calls per episode; 0: 30, or the benchmark's limit if continuous", 0);
}

arena::SessionLimits limits_of(const arena::World& world, std::uint32_t steps) {
  arena::SessionLimits limits = arena::usual_limits(world.task());
  if (steps > 0) limits.steps = steps;
  return limits;
}

}  // namespace enfilade::apps
