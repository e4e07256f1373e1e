/// \file  The formulas of the scorers, and the lists of them. Internal: scorer.h is the interface.
#pragma once
#include <array>
#include <limits>
#include <span>
#include <vector>

#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/scorer.h"

namespace enfilade::tasks::scorers {

/// What a formula gets. Metrics go to `out`, in the order of its table in tables.cpp.
using Scored = ScoredTrajectory;
using Out = std::span<double>;

/// \name The scorers of each benchmark, the default first
/// @{
extern const std::array<Scorer, 5> kR2r;
extern const std::array<Scorer, 1> kR2rLast;
extern const std::array<Scorer, 1> kR2rBack;
extern const std::array<Scorer, 4> kR4r;
extern const std::array<Scorer, 3> kRxr;
extern const std::array<Scorer, 3> kReverie;
extern const std::array<Scorer, 5> kCvdn;
extern const std::array<Scorer, 2> kSoon;
extern const std::array<Scorer, 2> kR2rCe;
extern const std::array<Scorer, 2> kRxrCe;
/// @}

// Enfilade's own, of any goal on graphs.
void own(const Scored& scored, Out out);
// In continuous space.
void vlnce(const ContinuousWalk& walk, std::span<const Point3> reference, Out out);
void etpnav(const ContinuousWalk& walk, std::span<const Point3> reference, Out out);

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

/// \name What several of them use
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
/// success * length / max(walked, length, guard); 0 if that is 0 / 0.
double spl(bool success, double length, double walked, double guard);
/// @}

}  // namespace enfilade::tasks::scorers
