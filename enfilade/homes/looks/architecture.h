/// \file  A plan's walls, floors, ceilings, doors, windows and stairs as triangles.
#pragma once
#include <vector>

#include "enfilade/homes/looks/home_parts.h"
#include "enfilade/homes/looks/style.h"

namespace enfilade::homes::looks {

/// Builds everything of a plan that is not furniture: walls with holes and thickness, skirting,
/// floors, ceilings, door frames and leaves, window frames with glassless panes (light comes in;
/// bodies don't get out: an invisible pane is an obstacle in truth and a thin glass surface of the
/// class window in the mesh's lower half only if it does not darken the room: see the source),
/// stairs with railings, and outside: ground and a plain facade. Each wall, floor, ceiling, door,
/// window, flight is an object of its own, with its room. Adds obstacles and things for doors,
/// windows and stairs, and portals to `portals`.
void build_architecture(const Plan& plan, const std::vector<RoomStyle>& styles, HomeParts parts,
                        std::vector<mesh::Portal>& portals);

/// One for each room of the plan, in its order; stairs' flights and landings are kept clear.
std::vector<RoomSpace> room_spaces(const Plan& plan);

}  // namespace enfilade::homes::looks
