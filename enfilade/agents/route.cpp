#include "enfilade/agents/route.h"

#include <fmt/format.h>
#include <algorithm>

#include "enfilade/core/errors.h"

namespace enfilade::agents {
namespace {

constexpr std::uint32_t kRound = 12;

}  // namespace

std::optional<Decision> Route::next(const Observation& seen, const Panorama& panorama) {
  if (!way_.empty() && way_.front() == seen.viewpoint) way_.pop_front();
  if (way_.empty()) return std::nullopt;
  const auto candidate =
      std::ranges::find(panorama.candidates, way_.front(), &sim::Candidate::viewpoint);
  if (candidate == panorama.candidates.end()) {
    throw ArgumentError(fmt::format("{}: the agent at {:?} cannot go to {:?}", seen.graph->scan(),
                                    seen.graph->id(seen.viewpoint), seen.graph->id(way_.front())));
  }
  const sim::Action action = step_towards(*candidate, seen.view_index);
  if (seen.view_index != candidate->view) {
    double right = action.heading_change.value;
    const std::uint32_t columns =
        (candidate->view % kRound + kRound - seen.view_index % kRound) % kRound;
    if (turning_ == Turning::kShorter && columns > kRound / 2) right = -right;
    return Decision::turn(right, action.elevation_change.value);
  }
  return Decision::go(action.index);
}

}  // namespace enfilade::agents
