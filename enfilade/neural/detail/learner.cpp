#include "enfilade/neural/detail/learner.h"

namespace enfilade::neural::detail {

Network::State as_state(const Weights& weights) {
  Network::State state;
  for (features::NamedArray& array : as_arrays(weights)) {
    state.storage.emplace_back(array.bytes.begin(), array.bytes.end());
    array.bytes = state.storage.back();
    state.arrays.push_back(std::move(array));
  }
  return state;
}

}  // namespace enfilade::neural::detail
