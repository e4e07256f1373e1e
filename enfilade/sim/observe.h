/// \file  From where agents are to what they see.
#pragma once
#include <span>
#include <vector>

#include "enfilade/render/renderer.h"
#include "enfilade/sim/simulator.h"

namespace enfilade::sim {

/// The view of each agent. \throws ArgumentError unless views.size() == state.scan.size()
void views_of(const StateSpans& state, std::span<render::View> views);

/// Prefetches the faces that agents will need after their next move. These are at
/// the viewpoints in their navigable lists, with headings and elevations as now. At most
/// `neighbours` per agent, nearest to the picture's middle first.
/// \param layers of the panoramas
void prefetch_neighbours(const StateSpans& state, std::size_t max_navigable, const Camera& camera,
                         std::span<const scan::Layer> layers, render::FaceCache& faces,
                         std::size_t neighbours = 4);

}  // namespace enfilade::sim
