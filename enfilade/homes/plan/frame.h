/// \file  Where corridors run: the skeletons of plans.
#pragma once
#include <optional>

#include "enfilade/homes/plan/model.h"

namespace enfilade::homes::plan {

struct FrameNeeds {
  HomeKind kind = HomeKind::kHouse;
  unsigned storeys = 1;
  double area = 100;  // m2 of one storey
  double run = 4.2;   // metres that a flight of stairs takes
};

/// One of several skeletons (hall through the middle, corridor across, L, U, comb), of drawn
/// proportions; nothing if what was drawn does not fit the area.
std::optional<Building> draw_building(const FrameNeeds& needs, Rng& rng);

}  // namespace enfilade::homes::plan
