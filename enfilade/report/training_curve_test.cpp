#include "enfilade/report/parts/result_parts.h"

#include <gtest/gtest.h>

namespace enfilade::report::parts {
namespace {

TEST(TrainingCurve, KeepsTheMeanAndTheNumberOfPoints) {
  std::vector<models::TrainRecord> records;
  for (std::uint64_t i = 0; i < 1000; ++i) records.push_back({i, i % 2 == 0 ? 1.0 : 3.0});
  const auto curve = training_curve(records, 400);
  EXPECT_EQ(curve.size(), 334U) << "three at a time, one left";
  EXPECT_EQ(curve[0].iteration, 1);
  EXPECT_NEAR(curve[0].loss, 5.0 / 3, 1e-12) << "(1 + 3 + 1) / 3, rounding aside";
  EXPECT_EQ(curve.back().iteration, 999);
  EXPECT_EQ(training_curve(records, 1000).size(), 1000U);
}

}  // namespace
}  // namespace enfilade::report::parts
