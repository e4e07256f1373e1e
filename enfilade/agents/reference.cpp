#include "enfilade/agents/reference.h"

#include "enfilade/agents/shortest.h"

namespace enfilade::agents {

void ReferenceAgent::start(std::span<const Observation> batch) { next_.assign(batch.size(), 0); }

void ReferenceAgent::act(std::span<const Observation> batch, std::span<Decision> decisions) {
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const Observation& seen = batch[i];
    if (seen.ended) continue;
    std::size_t& next = next_[i];
    const std::size_t last = seen.reference.size() - 1;
    while (next < last && seen.viewpoint == seen.reference[next]) ++next;
    decisions[i] = teacher_decision(seen, seen.reference[next]);
    if (decisions[i].stop) decisions[i].answer = true_answer(seen);
  }
}

}  // namespace enfilade::agents
