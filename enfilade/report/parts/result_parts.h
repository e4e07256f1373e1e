/// \file  The parts of the page about scores and training.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <vector>

#include "enfilade/models/training_log.h"
#include "enfilade/report/results_table.h"
#include "enfilade/report/run_directory.h"
#include "enfilade/report/scored_runs.h"

namespace enfilade::report::parts {

/// How far from the goal agents stop, by agent and split. "shortest" is left out: it stops there.
nlohmann::ordered_json errors_part(const ScoredRuns& runs);

/// Success by the length of the shortest path, by agent and split, with intervals.
nlohmann::ordered_json by_length_part(const ScoredRuns& runs);

/// Loss, navigation error and success over training, by agent, run and split.
/// \throws as models::load_training_log()
nlohmann::ordered_json curves_part(const RunDirectory& found);

/// A point of a curve of the loss: the means of some records.
struct CurvePoint {
  double iteration = 0;
  double loss = 0;
};
/// At most `most` points: each the mean of equally many consecutive records, the last of the rest.
/// \throws ArgumentError for 0
std::vector<CurvePoint> training_curve(std::span<const models::TrainRecord> records,
                                       std::size_t most);

/// Wilson's 95 % interval of a share. \pre n > 0
struct ShareInterval {
  double low = 0, high = 0;
};
ShareInterval wilson_interval(double share, double n) noexcept;

}  // namespace enfilade::report::parts
