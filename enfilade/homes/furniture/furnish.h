/// \file  Furniture and fittings of one room, placed as people place them.
#pragma once
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/homes/looks/home_parts.h"
#include "enfilade/homes/looks/style.h"

namespace enfilade::homes::furniture {

/// Furnishes a room: first the required pieces of its type (bed against a wall, chairs around a
/// table, sink below a mirror, desks with chairs, ...). Then optional ones that fit, clutter on
/// surfaces, pictures and curtains on walls, a rug, lamps. A way of at least 0.75 m stays free from
/// every door to every other. Draws from `rng` only.
void furnish(const looks::RoomSpace& space, const looks::RoomStyle& style, Rng& rng,
             looks::HomeParts parts);

/// All names of objects that furnish() may place, with their mpcat40 category and number of shapes:
/// for tests and docs.
struct CatalogueEntry {
  std::string noun;
  std::uint16_t category = 0;
  unsigned shapes = 0;
};
std::vector<CatalogueEntry> catalogue();

}  // namespace enfilade::homes::furniture
