#include "apps/enfilade/arena_world.h"

#include <map>
#include <mutex>
#include <utility>

#include "apps/enfilade/continuous/scenes.h"
#include "apps/enfilade/task_option.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"

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
  const auto words_from = [&words](const arena::Sights& sights) {
    return words ? words(sights) : arena::WordsSource();
  };
  const tasks::Benchmark* named = tasks::find_benchmark(task);
  if (named != nullptr && named->continuous()) {
    const auto& setup = agents::continuous_setup(*named);
    opened.sights.scene_of = [scenes = std::make_shared<SharedScenes>(data)](
                                 const std::string& scan) { return scenes->at(scan); };
    opened.world = arena::FreeWorld::open(setup, data->folder(), split, words_from(opened.sights));
    opened.title = named->title;
    return opened;
  }
  auto episodes =
      std::make_shared<const tasks::EpisodeSet>(episodes_of(*data, task_of(task, *data), split));
  opened.title = tasks::benchmark(episodes->task).title;
  opened.sights.data = data;
  opened.world =
      std::make_unique<arena::GraphWorld>(std::move(episodes), words_from(opened.sights));
  return opened;
}

}  // namespace enfilade::apps
