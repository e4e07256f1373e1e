/// \file  Actions of continuous space by the names that calls have.
#pragma once
#include <array>
#include <string_view>

#include "enfilade/continuous/simulator.h"

namespace enfilade::arena::detail {

struct Move {
  std::string_view name;
  continuous::Action action;
};
/// Looks last: R2R-CE has none.
inline constexpr std::array kMoves{
    Move{"forward", continuous::Action::kForward}, Move{"left", continuous::Action::kLeft},
    Move{"right", continuous::Action::kRight}, Move{"up", continuous::Action::kLookUp},
    Move{"down", continuous::Action::kLookDown}};

}  // namespace enfilade::arena::detail
