/// \file  What a plan must fulfil.
#pragma once
#include <string>
#include <vector>

#include "enfilade/homes/plan.h"

namespace enfilade::homes::plan {

/// Faults of a plan, in words; none if it is sound: rooms within the outline, apart from each
/// other, of fair size; openings in walls of both rooms, clear of corners, each other and flights;
/// all rooms connected as make_plan() promises; windows where people stay; stairs with landings.
std::vector<std::string> plan_faults(const Plan& plan);

}  // namespace enfilade::homes::plan
