#include "enfilade/neural/detail/learner.h"

#include "enfilade/core/errors.h"

namespace enfilade::neural::detail {

void Learner::begin_with(const features::TensorFile&) {
  throw ArgumentError("this agent begins with random weights alone");
}

Network::State as_state(const Weights& weights) {
  Network::State state;
  const Weights values = on_cpu(weights);
  for (features::NamedArray& array : as_arrays(values)) {
    state.storage.emplace_back(array.bytes.begin(), array.bytes.end());
    array.bytes = state.storage.back();
    state.arrays.push_back(std::move(array));
  }
  return state;
}

}  // namespace enfilade::neural::detail
