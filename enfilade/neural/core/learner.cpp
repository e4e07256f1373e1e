#include "enfilade/neural/core/learner.h"

#include "enfilade/core/errors.h"

namespace enfilade::neural::core {

void Learner::begin_with(const features::TensorFile&) {
  throw ArgumentError("this agent begins with random weights alone");
}

}  // namespace enfilade::neural::core
