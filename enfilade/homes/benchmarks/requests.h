/// \file  REVERIE: short requests that name a room and an object in it. Internal.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/homes/benchmarks/site.h"

namespace enfilade::homes::benchmarks {

/// The same path with three requests, for up to two objects that its last viewpoint shows. Room and
/// object are named so that no other object of the home fits both. Empty if no object there is
/// distinguishable.
std::vector<tasks::PathAnnotation> write_requests(const Site& site,
                                                  const tasks::PathAnnotation& path,
                                                  std::uint64_t seed);

}  // namespace enfilade::homes::benchmarks
