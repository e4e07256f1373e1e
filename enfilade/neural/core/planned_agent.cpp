#include "enfilade/neural/core/planned_agent.h"

#include <utility>

namespace enfilade::neural::core {

void PlannedAgent::enter(const tasks::EpisodeSet& episodes, const features::FeatureSet* features) {
  prepare(episodes, usable_features(config_, features));
  episodes_ = &episodes;
  panoramas_ = std::make_unique<agents::PanoramaCache>(episodes.graphs);
  slots_.clear();
}

void PlannedAgent::start(std::span<const agents::Observation> batch) {
  std::vector<std::size_t> episodes;
  for (const agents::Observation& seen : batch) {
    episodes.push_back(static_cast<std::size_t>(seen.episode - episodes_->episodes.data()));
  }
  slots_.clear();
  for (const tasks::Trajectory& trajectory : walk(episodes)) {
    Slot slot{agents::Route(turning_),
              {trajectory.turning_point, trajectory.object, trajectory.point}};
    std::vector<ViewpointIndex> way;
    for (const tasks::TrajectoryPoint& point : trajectory.points) {
      // An entry a turn, or the start: the agent is there already.
      if (!way.empty() ? way.back() != point.viewpoint
                       : point.viewpoint != trajectory.points.front().viewpoint) {
        way.push_back(point.viewpoint);
      }
    }
    slot.route.set(way);
    slots_.push_back(std::move(slot));
  }
}

void PlannedAgent::act(std::span<const agents::Observation> batch,
                       std::span<agents::Decision> decisions) {
  for (std::size_t i = 0; i < batch.size(); ++i) {
    if (batch[i].ended) continue;
    const ScanIndex scan = episodes_->graphs->at(batch[i].graph->scan());
    const auto next = slots_[i].route.next(batch[i], panoramas_->at({scan, batch[i].viewpoint}));
    decisions[i] = next ? *next : agents::Decision::stop_with(slots_[i].answer);
  }
}

}  // namespace enfilade::neural::core
