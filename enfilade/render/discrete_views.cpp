#include "enfilade/render/renderer.h"

namespace enfilade::render {

std::array<View, kDiscreteViews> discrete_views(ScanIndex scan, ViewpointIndex viewpoint) {
  constexpr std::size_t kHeadings = 12;
  std::array<View, kDiscreteViews> views;
  for (std::size_t k = 0; k < views.size(); ++k) {
    // Numbers that MatterSim computes, so that a view is drawn at the heading that its state tells.
    const double heading = static_cast<double>(k % kHeadings) * (2 * kPi / 12);
    const double elevation = (static_cast<double>(k / kHeadings) - 1) * (kPi / 6);
    views[k] = {scan, viewpoint, Radians(heading), Radians(elevation)};
  }
  return views;
}

}  // namespace enfilade::render
