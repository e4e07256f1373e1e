/// \file  The formulas of the public scorers. Internal: public_scorer.h lists them.
#pragma once
#include <limits>
#include <span>
#include <vector>

#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/results.h"

namespace enfilade::tasks::scorers {

/// Input of a formula. Metrics go to `out`, in the order of its table in public_scorer.cpp.
struct Scored {
  const graph::NavGraph& graph;
  const ReferencePath& reference;
  const Trajectory& trajectory;
};
using Out = std::span<double>;

// R2R, R2R-Last, R4R, RxR; the last of them R2R-Back.
void hamt(const Scored& scored, Out out);
void duet(const Scored& scored, Out out);
void valan(const Scored& scored, Out out);
void r4r_public(const Scored& scored, Out out);
void hamt_back(const Scored& scored, Out out);

void reverie_official(const Scored& scored, Out out);
void reverie_duet(const Scored& scored, Out out);
void reverie_hamt(const Scored& scored, Out out);

void cvdn_planner(const Scored& scored, Out out);
void cvdn_player(const Scored& scored, Out out);
void cvdn_trusted(const Scored& scored, Out out);
void cvdn_hamt(const Scored& scored, Out out);
void cvdn_valan(const Scored& scored, Out out);

void soon_duet(const Scored& scored, Out out);
void soon_official(const Scored& scored, Out out);

/// \name Shared by several scorers
/// @{
inline constexpr double kSuccessDistance = MetricOptions{}.success_distance;  ///< metres
inline constexpr double kGuard = 0.01;  ///< metres: the least divisor of SPL in some of them

/// Where a scorer has no value.
inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::vector<ViewpointIndex> viewpoints_of(const Trajectory& trajectory);
/// Least distance from a viewpoint to any of several; infinite if there is none.
double nearest(const graph::NavGraph& graph, ViewpointIndex from,
               std::span<const ViewpointIndex> to);
double action_steps(const Trajectory& trajectory);
/// success * length / max(trajectory's length, length, guard); 0 if that is 0 / 0.
double spl(bool success, double length, double walked, double guard);
/// @}

}  // namespace enfilade::tasks::scorers
