#include "enfilade/core/descriptor.h"

#include <unistd.h>

namespace enfilade {

Descriptor::~Descriptor() {
  if (number_ >= 0) close(number_);
}

}  // namespace enfilade
