/// \file  A plan's walls, floors, ceilings, doors, windows and stairs as triangles.
#pragma once
#include <vector>

#include "enfilade/homes/looks/home_parts.h"
#include "enfilade/homes/looks/style.h"

namespace enfilade::homes::looks {

/// Builds the parts of a plan that are not furniture. Inside: walls with their openings, skirting,
/// floors, ceilings, door frames and leaves, window frames, stairs with railings. Outside: the
/// ground and a plain facade. Windows have no glass, so that light comes in, but count as
/// obstacles. Each wall, floor, ceiling, door, window and flight is an object of its own, with its
/// room. Adds obstacles and objects for doors, windows and stairs; adds the openings that let light
/// in to `portals`.
void build_architecture(const Plan& plan, const std::vector<RoomStyle>& styles, HomeParts parts,
                        std::vector<mesh::Portal>& portals);

/// The space for furniture in each room, in the plan's order. Flights and landings are kept clear.
std::vector<RoomSpace> room_spaces(const Plan& plan);

}  // namespace enfilade::homes::looks
