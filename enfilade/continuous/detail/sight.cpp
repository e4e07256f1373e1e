#include "enfilade/continuous/detail/sight.h"

#include <numeric>

namespace enfilade::continuous::detail {

namespace {

// Twice the area, counter-clockwise positive, of the first polygon: all turn the same way.
double orientation(const mesh::FloorPolygons& floor) {
  const mesh::FloorPolygon& p = floor.polygons.front();
  const auto at = [&](std::size_t k) {
    const mesh::PolygonCorner& c = floor.corners[p.corners[k]];
    return Flat{static_cast<double>(c[0]), static_cast<double>(c[1])};
  };
  double twice = 0;
  for (std::size_t k = 2; k < p.size(); ++k) twice += turn(at(k - 1) - at(0), at(k) - at(0));
  return twice;
}

}  // namespace

FlatFloor::FlatFloor(const NavigationMesh& mesh) {
  const mesh::FloorPolygons& floor = mesh.floor();
  for (std::size_t c = 0; c < floor.corners.size(); ++c) {
    corners_.push_back(to_double(mesh.corner(c)));
  }
  const bool clockwise = orientation(floor) < 0;
  first_around_.assign(corners_.size() + 1, 0);
  for (const mesh::FloorPolygon& p : floor.polygons) {
    first_side_.push_back(static_cast<std::uint32_t>(sides_.size()));
    const std::size_t n = p.size();
    for (std::size_t k = 0; k < n; ++k) {
      // Turned round, the side from corner k leads to the one before it.
      const std::size_t corner = clockwise ? n - 1 - k : k;
      const std::size_t side = clockwise ? (corner + n - 1) % n : corner;
      const std::uint16_t beyond = p.beyond[side];
      sides_.push_back({p.corners[corner], beyond == mesh::FloorPolygon::kNone
                                               ? kRim
                                               : static_cast<std::uint32_t>(beyond)});
      ++first_around_[std::size_t{p.corners[corner]} + 1];
    }
  }
  first_side_.push_back(static_cast<std::uint32_t>(sides_.size()));
  std::partial_sum(first_around_.begin(), first_around_.end(), first_around_.begin());
  around_.resize(sides_.size());
  std::vector<std::uint32_t> next(first_around_.begin(), first_around_.end() - 1);
  for (std::uint32_t p = 0; p < polygons(); ++p) {
    for (const PolygonSide& side : sides(p)) around_[next[side.corner]++] = p;
  }
}

}  // namespace enfilade::continuous::detail
