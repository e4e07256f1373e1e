#include "enfilade/service/evaluation/shown_metrics.h"

#include <cmath>

#include "enfilade/core/check.h"

namespace enfilade::service::evaluation {
namespace {

// 0.01 of shares are 0.1 m: what papers' tables show of both.
constexpr double kMetresOfStep = 10;
// Longer than what agents of any published table are away on average; a bound has to be there, as
// an unbounded number could give away any number of bits.
constexpr double kMostMetres = 30;

std::int64_t first_level(const Grid& grid) { return std::llround(grid.least / grid.step); }
std::int64_t last_level(const Grid& grid) { return std::llround(grid.most / grid.step); }

}  // namespace

std::int64_t Grid::levels() const { return last_level(*this) - first_level(*this) + 1; }

double Grid::round(double value) const {
  const auto first = static_cast<double>(first_level(*this));
  const auto last = static_cast<double>(last_level(*this));
  // fmax() and fmin() pass over what is no number.
  const double kept = std::fmin(std::fmax(std::round(value / step), first), last);
  // Counted from the larger part of a whole where there is one: 0.07, not 0.07000000000000001.
  const double parts = std::round(1 / step);
  return std::abs(parts * step - 1) < 1e-9 ? kept / parts : kept * step;
}

Grid grid_of(const Phase& phase, const tasks::Measure& measure) {
  EN_CHECK(measure.tells_goals);
  if (measure.unit == tasks::Unit::kShare) return {phase.step, 1};
  // Errors begin at 0; a trajectory away from the goal has negative progress.
  const bool progress = measure.better == tasks::Better::kHigher;
  return {kMetresOfStep * phase.step, kMostMetres, progress ? -kMostMetres : 0};
}

}  // namespace enfilade::service::evaluation
