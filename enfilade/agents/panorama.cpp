#include "enfilade/agents/panorama.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/render/renderer.h"

namespace enfilade::agents {
namespace {

using render::kDiscreteViews;

constexpr std::uint32_t kColumns = 12;
constexpr double kStep = 30;  // degrees between views

const render::View& view_at(std::uint32_t view) {
  static const auto kAll = render::discrete_views({}, {});
  return kAll[view];
}

}  // namespace

PanoramaCache::PanoramaCache(std::shared_ptr<const graph::GraphSet> graphs,
                             const sim::SimulatorConfig& config)
    : finder_(std::move(graphs), config) {}

const Panorama& PanoramaCache::at(graph::Location location) {
  const auto known = known_.find({location.scan, location.viewpoint});
  if (known != known_.end()) return known->second;
  Panorama panorama{finder_.find(location), {}};
  std::array<bool, kDiscreteViews> used{};
  for (const sim::Candidate& candidate : panorama.candidates) {
    panorama.token_views.push_back(candidate.view);
    used[candidate.view] = true;
  }
  for (std::uint32_t view = 0; view < kDiscreteViews; ++view) {
    if (!used[view]) panorama.token_views.push_back(view);
  }
  return known_.emplace(std::pair(location.scan, location.viewpoint), std::move(panorama))
      .first->second;
}

AngleFeature angle_feature(Radians heading, Radians elevation) {
  return {static_cast<float>(std::sin(heading.value)), static_cast<float>(std::cos(heading.value)),
          static_cast<float>(std::sin(elevation.value)),
          static_cast<float>(std::cos(elevation.value))};
}

Radians view_heading(std::uint32_t view) { return view_at(view).heading; }
Radians view_elevation(std::uint32_t view) { return view_at(view).elevation; }

std::uint32_t level_view(Radians heading) {
  const long steps = std::lround(to_degrees(wrap_heading(heading)) / kStep);
  return kColumns + static_cast<std::uint32_t>(steps) % kColumns;
}

std::uint32_t view_after(const sim::Action& action, std::uint32_t view) {
  const auto step = [](Radians change) { return (change.value > 0) - (change.value < 0); };
  const int row = std::clamp(static_cast<int>(view / kColumns) + step(action.elevation_change), 0,
                             static_cast<int>(kDiscreteViews / kColumns) - 1);
  const auto column =
      view % kColumns + kColumns + static_cast<std::uint32_t>(step(action.heading_change));
  return static_cast<std::uint32_t>(row) * kColumns + column % kColumns;
}

std::optional<std::uint32_t> arrival_view(const Panorama& panorama, ViewpointIndex neighbour) {
  const auto found = std::ranges::find(panorama.candidates, neighbour, &sim::Candidate::viewpoint);
  if (found == panorama.candidates.end()) return std::nullopt;
  return found->view;
}

sim::Action step_towards(const sim::Candidate& candidate, std::uint32_t view) {
  const std::uint32_t row = view / kColumns, wanted = candidate.view / kColumns;
  if (row != wanted) return {0, Radians(0), degrees(row < wanted ? kStep : -kStep)};
  if (view != candidate.view) return {0, degrees(kStep), Radians(0)};
  return {candidate.index, Radians(0), Radians(0)};
}

std::optional<Decision> Route::next(const Observation& seen, const Panorama& panorama) {
  if (!way_.empty() && way_.front() == seen.viewpoint) way_.pop_front();
  if (way_.empty()) return std::nullopt;
  const auto candidate =
      std::ranges::find(panorama.candidates, way_.front(), &sim::Candidate::viewpoint);
  if (candidate == panorama.candidates.end()) {
    throw ArgumentError(fmt::format("{}: the agent at {} cannot go to {}", seen.graph->scan(),
                                    quote(seen.graph->id(seen.viewpoint)),
                                    quote(seen.graph->id(way_.front()))));
  }
  const sim::Action action = step_towards(*candidate, seen.view_index);
  if (seen.view_index != candidate->view) {
    double right = action.heading_change.value;
    const std::uint32_t columns =
        (candidate->view % kColumns + kColumns - seen.view_index % kColumns) % kColumns;
    if (turning_ == Turning::kShorter && columns > kColumns / 2) right = -right;
    return Decision::turn(right, action.elevation_change.value);
  }
  return Decision::go(action.index);
}

}  // namespace enfilade::agents
