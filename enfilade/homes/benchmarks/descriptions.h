/// \file  SOON: descriptions of an object, and where it is on the sphere. Internal.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/homes/benchmarks/site.h"

namespace enfilade::homes::benchmarks {

/// An entry: paths from several starts to viewpoints that show one object, all with the same three
/// descriptions and boxes. The first start is the path's own. A description has four texts and the
/// whole: the object's name, its appearance, its neighbours, its place. Viewpoints from which its
/// outline lies across heading 0 have no box, as the public scorers cannot handle one. The ids are
/// left to the caller; the group is the path's id. Empty if no object at the path's end has a
/// description that fits no other.
std::vector<tasks::PathAnnotation> write_descriptions(const Site& site,
                                                      const tasks::PathAnnotation& path,
                                                      std::uint64_t seed);

}  // namespace enfilade::homes::benchmarks
