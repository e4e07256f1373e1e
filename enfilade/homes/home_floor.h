/// \file  The navigation mesh of a synthetic home.
#pragma once
#include "enfilade/homes/built_home.h"
#include "enfilade/mesh/floor_polygons.h"

namespace enfilade::homes {

/// Polygons of the floors of all rooms, from the mesh alone. The landscape around is left out.
/// \param body  size of the body
/// \throws as mesh::make_floor_polygons()
mesh::FloorPolygons make_home_floor(const BuiltHome& built, const mesh::Body& body);

}  // namespace enfilade::homes
