#include "enfilade/neural/duet/duet_split.h"

#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/neural/core/split_rollout.h"
#include "enfilade/neural/duet/recording.h"

namespace enfilade::neural::duet {
namespace {

void check(const features::ObjectSet* objects, std::int64_t wanted) {
  constexpr std::size_t kClasses = 1000;  // scores that published files have behind the features
  if (objects == nullptr) {
    throw ArgumentError(
        "the agent names objects, so it needs their features (enfilade evaluate --objects FILE)");
  }
  const auto size = static_cast<std::size_t>(wanted);
  if (objects->dimensions() == size || objects->dimensions() == size + kClasses) return;
  throw ArgumentError(fmt::format("{}: {} numbers an object; the network was made for {}",
                                  objects->file().string(), objects->dimensions(), size));
}

// The views of a feature set, and the objects of a set.
class ViewSurroundings : public Surroundings {
 public:
  ViewSurroundings(const tasks::EpisodeSet& episodes, const core::ViewFeatures* features,
                   std::shared_ptr<const features::ObjectSet> objects)
      : graphs_(*episodes.graphs), features_(features), objects_(std::move(objects)) {}

  void views(const graph::NavGraph& graph, ViewpointIndex viewpoint,
             std::span<float> out) override {
    if (features_ == nullptr) return;
    const std::size_t n = features_->dimensions();
    const ScanIndex scan = graphs_.at(graph.scan());
    for (std::uint32_t view = 0; view < core::ViewFeatures::kViews; ++view) {
      features_->copy(scan, viewpoint, view, out.subspan(view * n, n));
    }
  }
  std::vector<features::ObjectView> objects(const graph::NavGraph& graph,
                                            ViewpointIndex viewpoint) override {
    if (objects_ == nullptr) return {};
    const auto seen = objects_->objects(graph.scan(), graph.id(viewpoint));
    return {seen.begin(), seen.end()};
  }
  void object(const graph::NavGraph& graph, ViewpointIndex viewpoint, std::size_t i,
              std::span<float> out) override {
    objects_->copy(graph.scan(), graph.id(viewpoint), i, out);
  }

 private:
  const graph::GraphSet& graphs_;
  const core::ViewFeatures* features_;
  std::shared_ptr<const features::ObjectSet> objects_;
};

Radians direction(const graph::NavGraph& graph, ViewpointIndex from, ViewpointIndex to) {
  const auto a = graph.position(from), b = graph.position(to);
  return wrap_heading(Radians(std::atan2(double{b.x} - double{a.x}, double{b.y} - double{a.y})));
}

tasks::Trajectory trajectory_of(const EpisodeRollout& walk, const graph::NavGraph& graph,
                                std::uint32_t start_view, std::size_t episode) {
  tasks::Trajectory trajectory;
  trajectory.episode = episode;
  trajectory.actions = walk.path.size() - 1;
  trajectory.object = walk.object;
  for (const auto& part : walk.path) {
    for (const ViewpointIndex viewpoint : part) {
      const Radians heading = trajectory.points.empty()
                                  ? agents::view_heading(start_view)
                                  : direction(graph, trajectory.points.back().viewpoint, viewpoint);
      trajectory.points.push_back({viewpoint, heading, Radians(0)});
    }
  }
  return trajectory;
}

}  // namespace

DuetSplit::DuetSplit(const tasks::EpisodeSet& episodes, const models::InstructionWords& words,
                     const models::TrainConfig& config, const features::FeatureSet* features,
                     std::shared_ptr<const features::ObjectSet> objects)
    : episodes_(episodes), words_(words) {
  std::vector<std::vector<std::int64_t>> ids =
      words.encode(episodes, config.network.max_words, config.network.inputs.language);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const tasks::Episode& episode = episodes.episodes[i];
    const tasks::ReferencePath& path = episodes.path_of(episode);
    RolloutEpisode walk{episode.instruction_id,
                        path.scan,
                        path.viewpoints.front(),
                        agents::level_view(path.heading),
                        std::move(ids[i]),
                        {},
                        {}};
    if (!goal_hidden(path)) walk.reference = path.viewpoints;
    if (const auto* object = std::get_if<tasks::SeenObject>(&path.goal))
      walk.object = std::to_string(object->id);
    walks_.push_back(std::move(walk));
  }
  if (features != nullptr) features_.emplace(*features, episodes);
  if (config.duet.object == 0) objects.reset();
  if (config.duet.object != 0) check(objects.get(), config.duet.object);
  surroundings_ = std::make_unique<ViewSurroundings>(episodes, features_ ? &*features_ : nullptr,
                                                     std::move(objects));
  runner_ = std::make_unique<RolloutRunner>(episodes.graphs, *surroundings_);
}

std::vector<RolloutEpisode> DuetSplit::batch(std::span<const std::size_t> episodes) const {
  std::vector<RolloutEpisode> batch;
  batch.reserve(episodes.size());
  for (const std::size_t index : episodes) batch.push_back(walks_[index]);
  return batch;
}

std::vector<tasks::Trajectory> rollout_episodes(const DuetNetwork& network, DuetSplit& split,
                                                std::span<const std::size_t> episodes,
                                                const StepWatcher& watcher) {
  const c10::NoGradGuard no_gradients;
  const std::vector<RolloutEpisode> batch = split.batch(episodes);
  const Rollout rollout = split.runner().run(network, batch, {}, watcher);
  std::vector<tasks::Trajectory> trajectories;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    trajectories.push_back(trajectory_of(rollout.episodes[i],
                                         split.episodes().graphs->graph(batch[i].scan),
                                         batch[i].start_view, episodes[i]));
  }
  return trajectories;
}

std::vector<tasks::Trajectory> rollout_and_write(const DuetNetwork& network, DuetSplit& split,
                                                 const SplitRollout& options,
                                                 const Progress& progress) {
  return core::rollout_and_write<DuetRecording>(network, split, options, progress);
}

}  // namespace enfilade::neural::duet
