#include "enfilade/neural/duet/duet_split.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/models/decisions.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::neural::duet {
namespace {

std::vector<float> row_of(const at::Tensor& values, std::size_t row) {
  const at::Tensor one = values.select(0, static_cast<std::int64_t>(row))
                             .to(at::kCPU, at::kFloat)
                             .contiguous()
                             .view({-1});
  const float* data = one.data_ptr<float>();
  return {data, data + one.numel()};
}

// The probabilities of the viewpoint's branch, by rows of the map; none for what is not to be seen.
std::vector<std::optional<float>> local_probabilities(const StepOfAll& step, std::size_t row,
                                                      std::size_t nodes) {
  const std::vector<float> logits = row_of(step.output->local_logits, row);
  const std::vector<float> shares = models::probabilities(logits);
  const at::Tensor places = step.input->node_of_token.select(0, static_cast<std::int64_t>(row))
                                .to(at::kCPU, at::kLong)
                                .contiguous();
  const std::int64_t* of_token = places.data_ptr<std::int64_t>();
  std::vector<std::optional<float>> by_node(nodes);
  by_node[0] = shares[0];
  for (std::size_t token = 1; token < shares.size(); ++token) {
    const auto node = of_token[token];
    if (node < 1 || static_cast<std::size_t>(node) >= nodes || !std::isfinite(logits[token])) {
      continue;
    }
    auto& share = by_node[static_cast<std::size_t>(node)];
    share = share.value_or(0) + shares[token];
  }
  return by_node;
}

std::string likeliest_object(const StepOfAll& step, std::size_t row) {
  const StepRow& seen = step.rows[row];
  if (!step.output->object_logits.defined() || seen.objects.empty()) return {};
  const std::vector<float> logits = row_of(step.output->object_logits, row);
  const auto best = std::ranges::max_element(logits) - logits.begin();
  const std::ptrdiff_t object = best - 1 - static_cast<std::ptrdiff_t>(seen.views);
  if (object < 0 || object >= std::ssize(seen.objects)) return {};
  return seen.objects[static_cast<std::size_t>(object)].id;
}

// Records the steps of rollout_episodes(). One thread at a time.
class DuetRecording {
 public:
  // Of all episodes of a split.
  explicit DuetRecording(const DuetSplit& split)
      : recorder_(models::AgentKind::kDuet, split.episodes().episodes.size()) {
    for (std::size_t i = 0; i < split.episodes().episodes.size(); ++i) {
      std::vector<std::string> text;
      for (const std::int64_t id : split.episode(i).words) text.push_back(split.words().word(id));
      recorder_.read(i, std::move(text));
    }
  }
  const models::DecisionRecorder& recorder() const noexcept { return recorder_; }

  // An observer of a walk of these episodes, which have to stay as long as it is used.
  StepWatcher observer(std::span<const std::size_t> episodes) {
    return [this, episodes](const StepOfAll& step) {
      for (std::size_t row = 0; row < step.rows.size(); ++row) {
        add(step, row, episodes[step.rows[row].episode]);
      }
    };
  }

 private:
  void add(const StepOfAll& step, std::size_t row, std::size_t episode) {
    const StepRow& seen = step.rows[row];
    const TopologicalMap& map = *seen.map;
    const std::vector<float> fused = row_of(step.output->fused_logits, row);
    const std::vector<float> common = models::probabilities(fused);
    const std::vector<float> global =
        models::probabilities(row_of(step.output->global_logits, row));
    const auto local = local_probabilities(step, row, common.size());
    std::map<ViewpointIndex, float>& stops = stops_[episode];
    stops[seen.pose.viewpoint] = common[0];

    models::RecordedStep recorded{seen.pose.viewpoint, seen.pose.heading(), seen.pose.elevation()};
    recorded.map_share = row_of(step.output->fuse_weight, row).at(0);
    recorded.choices.push_back({std::nullopt, common[0], global[0], local[0]});
    for (std::size_t i = 0; i < seen.nodes.size(); ++i) {
      const ViewpointIndex there = map.viewpoint(seen.nodes[i]);
      const bool visited = map.visited(seen.nodes[i]);
      const auto stop = stops.find(there);
      recorded.nodes.push_back(
          {there, visited,
           visited && stop != stops.end() ? std::optional(stop->second) : std::nullopt});
      if (!std::isfinite(fused[i + 1])) continue;
      if (seen.goes_to == there) recorded.chosen = recorded.choices.size();
      recorded.choices.push_back({there, common[i + 1], global[i + 1], local[i + 1]});
    }
    if (seen.goes_to) {
      map.path(*map.find(seen.pose.viewpoint), *map.find(*seen.goes_to), recorded.way);
    }
    recorded.object = likeliest_object(step, row);
    recorder_.add(episode, std::move(recorded));
  }

  models::DecisionRecorder recorder_;
  std::map<std::size_t, std::map<ViewpointIndex, float>> stops_;  // by episode
};

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
