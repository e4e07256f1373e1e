/// \file  Doors, arches, windows and the front door of a plan whose rooms are known.
#pragma once
#include <optional>
#include <vector>

#include "enfilade/homes/plan/model.h"

namespace enfilade::homes::plan {

/// Cells are the plan's rooms, in the same order; `middle` is the outline between the outer walls'
/// middle lines; the front is its side `front`.
struct Sketch {
  std::vector<Cell> cells;
  std::optional<Flight> flight;
  Rect middle;
  Side front = Side::kMinusY;
};

/// \pre plan has rooms and no openings. False if a door found no place.
bool add_openings(const Sketch& sketch, Plan& plan, Rng& rng);

/// The floor in front of an opening (kStand deep) on both sides, and what its open leaf covers.
Rect opening_zone(const Plan& plan, const Opening& opening);
std::optional<Rect> leaf_zone(const Plan& plan, const Opening& opening);
double wall_thickness(const Plan& plan, const Opening& opening);

}  // namespace enfilade::homes::plan
