// Any bytes are one of Habitat's navigation meshes or refused. Queries on an accepted one stay
// within memory and end.
#include <cstddef>
#include <cstdint>

#include "enfilade/continuous/habitat/path_finder.h"
#include "enfilade/core/errors.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  using namespace enfilade::continuous::habitat;
  try {
    const PathFinder floor(parse_nav_mesh({data, size}, "fuzz"));
    const Vec3f a{-1, 0, -1}, b{2, 0, 1};
    floor.path(a, b);
    for (const Moves moves : {Moves::kSlide, Moves::kStop}) floor.step(a, b, moves);
    floor.closest_obstacle(a);
    floor.random_point();
    floor.random_point_near(a, 1);
    floor.vertices();
  } catch (const InvalidInput&) {
  }
  return 0;
}
