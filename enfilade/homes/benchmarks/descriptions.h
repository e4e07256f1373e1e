/// \file  SOON: descriptions of an object, and where it is on the sphere. Internal.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/homes/benchmarks/site.h"

namespace enfilade::homes::benchmarks {

/// An entry: paths from several starts, the first of them the path's own, to viewpoints that show
/// one thing, all with the same three descriptions and boxes. A description has four texts and the
/// whole: what it is, how it looks, what is near it, where it is. Viewpoints from which its outline
/// lies across heading 0 have no box, as the public scorers cannot judge one. The ids are left to
/// the caller; the group is the path's id. Empty if no thing at the path's end can be described so
/// that no other fits.
std::vector<tasks::PathAnnotation> write_descriptions(const Site& site,
                                                      const tasks::PathAnnotation& path,
                                                      std::uint64_t seed);

}  // namespace enfilade::homes::benchmarks
