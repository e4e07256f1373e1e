/// \file  Plans with a limit of one's own on how often one is drawn.
#pragma once
#include "enfilade/synth/plan.h"

namespace enfilade::synth::detail {

/// As synth::make_plan(), which gives up very late.
Plan make_plan(const PlanOptions& options, unsigned most_draws);

}  // namespace enfilade::synth::detail
