/// \file  Rooms put side by side into the strips of a frame.
#pragma once
#include <optional>
#include <vector>

#include "enfilade/homes/plan/model.h"
#include "enfilade/homes/plan/program.h"

namespace enfilade::homes::plan {

struct Layout {
  std::vector<Cell> cells;  // the corridor's pieces first
  double score = 0;         // higher is better
};

/// The best of `trials` random orders of the program's rooms in which each fits, has windows if it
/// needs them and is reached without passing private rooms; nothing if there was none.
std::optional<Layout> fill(const Building& building, unsigned storey,
                           const std::vector<Chain>& program, unsigned trials, Rng& rng);

}  // namespace enfilade::homes::plan
