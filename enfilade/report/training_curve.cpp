#include "enfilade/report/training_curve.h"

#include <algorithm>

#include "enfilade/core/errors.h"

namespace enfilade::report {

std::vector<CurvePoint> training_curve(std::span<const models::TrainRecord> records,
                                       std::size_t most) {
  if (most == 0) throw ArgumentError("most: 0, not at least 1");
  const std::size_t each = std::max<std::size_t>(1, (records.size() + most - 1) / most);
  std::vector<CurvePoint> curve;
  for (std::size_t begin = 0; begin < records.size(); begin += each) {
    const auto part = records.subspan(begin, std::min(each, records.size() - begin));
    const auto n = static_cast<double>(part.size());
    CurvePoint mean;
    for (const models::TrainRecord& record : part) {
      mean.iteration += static_cast<double>(record.iteration) / n;
      mean.loss += record.loss / n;
    }
    curve.push_back(mean);
  }
  return curve;
}

}  // namespace enfilade::report
