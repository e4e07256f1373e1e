// Any bytes are a navigation mesh or refused; one that is accepted can be walked on, and ways are
// found on it, without leaving memory or going on for ever.
#include <xxhash.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "enfilade/continuous/geodesics.h"
#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  using namespace enfilade::continuous;
  // With the checksum that belongs to it, or few inputs would come farther.
  std::string bytes(reinterpret_cast<const char*>(data), size);
  if (size % 8 != 0 && size > 8) {
    bytes.resize(size - 8);
    const std::uint64_t sum = XXH3_64bits(bytes.data(), bytes.size());
    bytes.append(reinterpret_cast<const char*>(&sum), sizeof sum);
  }
  try {
    const mesh::FloorPolygons floor = parse_navigation_mesh(
        {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, "fuzz");
    if (floor.polygons.size() > 300) return 0;  // time
    const auto mesh = std::make_shared<const NavigationMesh>(floor);
    const Geodesics ways(mesh);
    Rng rng(1);
    Walker walker;
    for (int k = 0; k < 4; ++k) {
      const FloorPoint a = mesh->random_point(rng), b = mesh->random_point(rng);
      EN_CHECK(a.polygon < floor.polygons.size());
      EN_CHECK(ways.distance(a, b) >= 0);
      EN_CHECK(mesh->walk(walker, a, b.point).end.polygon < floor.polygons.size());
      mesh->walk(walker, a, b.point, Walls::kStop);
      mesh->nearest(b.point);
    }
  } catch (const Error&) {
    return 0;
  }
  return 0;
}
