#include "enfilade/sim/state.h"

namespace enfilade::sim {

StateBuffer::StateBuffer(std::size_t batch_size, std::size_t max_navigable)
    : scan_(batch_size),
      viewpoint_(batch_size),
      heading_(batch_size),
      elevation_(batch_size),
      view_index_(batch_size),
      step_(batch_size),
      navigable_count_(batch_size),
      navigable_viewpoint_(batch_size * max_navigable),
      navigable_rel_heading_(batch_size * max_navigable),
      navigable_rel_elevation_(batch_size * max_navigable),
      navigable_distance_(batch_size * max_navigable) {}

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
