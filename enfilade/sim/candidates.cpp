#include "enfilade/sim/candidates.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/render/renderer.h"

namespace enfilade::sim {
namespace {

using render::kDiscreteViews;

SimulatorConfig all_views(SimulatorConfig config) {
  config.batch_size = kDiscreteViews;
  config.viewing = Viewing::kDiscretized;
  config.threads = 1;
  return config;
}

}  // namespace

CandidateFinder::CandidateFinder(std::shared_ptr<const graph::GraphSet> graphs,
                                 const SimulatorConfig& config)
    : simulator_(std::move(graphs), all_views(config)) {
  for (const render::View& view : render::discrete_views({}, {})) {
    starts_.push_back({{}, view.heading, view.elevation});
  }
}

const std::vector<Candidate>& CandidateFinder::find(graph::Location location) {
  for (EpisodeStart& start : starts_) start.location = location;
  simulator_.new_episodes(starts_);
  found_.clear();
  for (std::uint32_t view = 0; view < kDiscreteViews; ++view) {
    for (std::uint32_t k = 1; k < simulator_.state().navigable_count[view]; ++k) keep(view, k);
  }
  return found_;
}

void CandidateFinder::keep(std::uint32_t view, std::uint32_t index) {
  const StateSpans& state = simulator_.state();
  const std::size_t at = view * state.max_navigable() + index;
  const double right = state.navigable_rel_heading[at];
  const double up = state.navigable_rel_elevation[at];
  const Candidate candidate{state.navigable_viewpoint[at],
                            view,
                            index,
                            Radians(right),
                            Radians(up),
                            Radians(state.heading[view] + right),
                            Radians(state.elevation[view] + up),
                            std::sqrt(right * right + up * up),
                            state.navigable_distance[at]};
  const auto known = std::ranges::find(found_, candidate.viewpoint, &Candidate::viewpoint);
  if (known == found_.end()) {
    found_.push_back(candidate);
  } else if (candidate.angle < known->angle) {
    *known = candidate;
  }
}

}  // namespace enfilade::sim
