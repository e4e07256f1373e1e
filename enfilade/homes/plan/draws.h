/// \file  Plans with a limit of one's own on how often one is drawn.
#pragma once
#include "enfilade/homes/plan.h"

namespace enfilade::homes::plan {

inline constexpr double kLeastWithStairs = 85;  ///< m2 of each storey of a home with stairs

/// As homes::make_plan(), which gives up very late.
Plan make_plan(const PlanOptions& options, unsigned most_draws);

}  // namespace enfilade::homes::plan
