/// \file  How well a trajectory follows its reference. Docs with equations: docs/tasks.md.
#pragma once
#include <array>
#include <span>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::tasks {

struct ReferencePath;
struct Trajectory;

/// What counts as success.
struct MetricOptions {
  double success_distance = 3.0;  ///< metres; success is strictly nearer (the paper, section 4.4)
};

/// The metrics of one trajectory against one reference path. Lengths are in metres along the graph.
/// d(a, b) is the shortest distance in the graph, P the trajectory, R the reference.
struct EpisodeMetrics {
  double steps = 0;              ///< entries of P less one: actions, turns included
  double moves = 0;              ///< changes of viewpoint
  double trajectory_length = 0;  ///< TL: sum of d over consecutive entries of P
  double reference_length = 0;   ///< the same of R
  double shortest = 0;           ///< d(first of R, last of R)
  double nav_error = 0;          ///< NE: d(last of P, last of R)
  double oracle_error = 0;       ///< least d(p, last of R) over P
  double success = 0;            ///< SR: 1 if NE < success_distance
  double oracle_success = 0;     ///< OSR: 1 if the oracle error is
  double spl = 0;                ///< success * shortest / max(TL, shortest); Anderson et al. 2018b
  double spl_refpath = 0;     ///< the same with R's length instead of shortest (DUET's evaluation)
  double dtw = 0;             ///< dynamic time warping of P onto R under d; Ilharco et al. 2019
  double ndtw = 0;            ///< exp(-dtw / (|R| success_distance))
  double sdtw = 0;            ///< success * ndtw
  double dtw_collapsed = 0;   ///< the same three with repeated entries of P taken once, so that
  double ndtw_collapsed = 0;  ///< turning on the spot costs nothing
  double sdtw_collapsed = 0;
  double coverage = 0;  ///< mean over R of exp(-least d to P / success_distance); Jain et al. 2019
  double cls = 0;       ///< coverage weighted by length score (same paper)
};

/// A metric's name and place, for tables, files and averages over all of them.
struct MetricField {
  const char* name;  ///< as in results of `enfilade score --json`: "nav_error"
  double EpisodeMetrics::*field;
};
/// All of EpisodeMetrics, in its order.
inline constexpr auto kMetricFields = std::to_array<MetricField>({
    {"steps", &EpisodeMetrics::steps},
    {"moves", &EpisodeMetrics::moves},
    {"trajectory_length", &EpisodeMetrics::trajectory_length},
    {"reference_length", &EpisodeMetrics::reference_length},
    {"shortest", &EpisodeMetrics::shortest},
    {"nav_error", &EpisodeMetrics::nav_error},
    {"oracle_error", &EpisodeMetrics::oracle_error},
    {"success", &EpisodeMetrics::success},
    {"oracle_success", &EpisodeMetrics::oracle_success},
    {"spl", &EpisodeMetrics::spl},
    {"spl_refpath", &EpisodeMetrics::spl_refpath},
    {"dtw", &EpisodeMetrics::dtw},
    {"ndtw", &EpisodeMetrics::ndtw},
    {"sdtw", &EpisodeMetrics::sdtw},
    {"dtw_collapsed", &EpisodeMetrics::dtw_collapsed},
    {"ndtw_collapsed", &EpisodeMetrics::ndtw_collapsed},
    {"sdtw_collapsed", &EpisodeMetrics::sdtw_collapsed},
    {"coverage", &EpisodeMetrics::coverage},
    {"cls", &EpisodeMetrics::cls},
});

/// Sum of the shortest distances between consecutive viewpoints, metres; a repeated one costs
/// nothing, one out of reach +inf. \pre viewpoints < graph.size()
double walked(const graph::NavGraph& graph, std::span<const ViewpointIndex> path);

/// Allocates nothing but the row of the time warping. O(|P| |R|).
/// \pre neither is empty; viewpoints < graph.size(). Distances are +inf where out of reach.
EpisodeMetrics compute_metrics(const graph::NavGraph& graph,
                               std::span<const ViewpointIndex> trajectory,
                               std::span<const ViewpointIndex> reference,
                               const MetricOptions& options = {});
/// The same for a trajectory by its episode's goal. For goals other than NearEnd, `success`,
/// `nav_error`, `oracle_success`, `oracle_error`, `shortest` and `spl` are those of judge()
/// (goal_distance.h).
/// \pre the goal is not hidden; as above
EpisodeMetrics compute_metrics(const graph::NavGraph& graph, const ReferencePath& path,
                               const Trajectory& trajectory, const MetricOptions& options = {});

}  // namespace enfilade::tasks
