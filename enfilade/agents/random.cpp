#include "enfilade/agents/random.h"

namespace enfilade::agents {
namespace {

constexpr std::uint64_t kHeadings = 12;

Decision decide(std::uint64_t& turns, int& moves, const Observation& seen) {
  if (turns > 0) {
    --turns;
    return Decision::turn(1);
  }
  if (moves == 0) return Decision::stop_here();
  if (seen.navigable.size() < 2) return Decision::turn(1);
  --moves;
  return Decision::go(1);
}

}  // namespace

void RandomAgent::start(std::span<const Observation> batch) {
  plans_.clear();
  for (const Observation& seen : batch) plans_.push_back({seen.rng->below(kHeadings), kMoves});
}

void RandomAgent::act(std::span<const Observation> batch, std::span<Decision> decisions) {
  for (std::size_t i = 0; i < batch.size(); ++i) {
    if (batch[i].ended) continue;
    decisions[i] = decide(plans_[i].turns, plans_[i].moves, batch[i]);
  }
}

}  // namespace enfilade::agents
