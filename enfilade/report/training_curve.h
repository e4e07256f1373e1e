/// \file  The curve of a training's loss, with few enough points to draw.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "enfilade/models/training_log.h"

namespace enfilade::report {

/// A point of the curve.
struct CurvePoint {
  double iteration = 0;  ///< mean of the records that the point stands for
  double loss = 0;       ///< likewise
};

/// At most `most` points: each the mean of equally many consecutive records, the last of the rest.
/// \throws ArgumentError for 0
std::vector<CurvePoint> training_curve(std::span<const models::TrainRecord> records,
                                       std::size_t most);

}  // namespace enfilade::report
