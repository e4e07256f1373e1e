#include "enfilade/sim/state.h"

namespace enfilade::sim {

StateBuffer::StateBuffer(std::size_t batch_size, std::size_t max_navigable) {
  const auto resize = [](std::size_t size, auto&... arrays) { (arrays.resize(size), ...); };
  resize(batch_size, scan_, viewpoint_, heading_, elevation_, view_index_, step_, navigable_count_);
  resize(batch_size * max_navigable, navigable_viewpoint_, navigable_rel_heading_,
         navigable_rel_elevation_, navigable_distance_);
}

StateSpans StateBuffer::spans() noexcept {
  return {scan_,
          viewpoint_,
          heading_,
          elevation_,
          view_index_,
          step_,
          navigable_count_,
          navigable_viewpoint_,
          navigable_rel_heading_,
          navigable_rel_elevation_,
          navigable_distance_};
}

}  // namespace enfilade::sim
