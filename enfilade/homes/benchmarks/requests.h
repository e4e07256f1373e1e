/// \file  REVERIE: short requests that name a room and an object in it. Internal.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/homes/benchmarks/site.h"

namespace enfilade::homes::benchmarks {

/// For up to two things that the path's last viewpoint shows, the same path with three requests:
/// room and thing are named so that no other thing of the home fits both. None if nothing there can
/// be told apart.
std::vector<tasks::PathAnnotation> write_requests(const Site& site,
                                                  const tasks::PathAnnotation& path,
                                                  std::uint64_t seed);

}  // namespace enfilade::homes::benchmarks
