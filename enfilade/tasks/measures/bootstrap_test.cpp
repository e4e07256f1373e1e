#include "enfilade/tasks/bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"

namespace enfilade::tasks {
namespace EN_UNIT {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<std::size_t> one_each(std::size_t n) {
  std::vector<std::size_t> groups(n);
  std::iota(groups.begin(), groups.end(), std::size_t{0});
  return groups;
}

std::vector<double> uniform_numbers(std::size_t n) {
  Rng rng(7);
  std::vector<double> values(n);
  for (double& value : values) value = rng.uniform();
  return values;
}

double width(const MeanInterval& interval) { return interval.high - interval.low; }

TEST(Bootstrap, AConstantHasAnIntervalOfOnePoint) {
  const std::vector<double> values(30, 2.5);
  const MeanInterval mean = bootstrap_means(values, 1, one_each(30))[0];
  EXPECT_EQ(mean.mean, 2.5);
  EXPECT_EQ(mean.low, 2.5);
  EXPECT_EQ(mean.high, 2.5);
}

TEST(Bootstrap, TwoValuesGiveTheirOwnRange) {
  // A quarter of the samples has the mean 0, a quarter 1: far more than 2.5 % each.
  const MeanInterval mean =
      bootstrap_means(std::vector<double>{0, 1}, 1, std::vector<std::size_t>{0, 1})[0];
  EXPECT_EQ(mean.mean, 0.5);
  EXPECT_EQ(mean.low, 0);
  EXPECT_EQ(mean.high, 1);
}

TEST(Bootstrap, OfManyIndependentValuesIsTheNormalInterval) {
  const std::size_t n = 2000;
  const std::vector<double> values = uniform_numbers(n);
  BootstrapOptions options;
  options.samples = 4000;
  const MeanInterval mean = bootstrap_means(values, 1, one_each(n), options)[0];
  const double normal = 2 * 1.95996 * std::sqrt(1.0 / 12 / double(n));
  // Each of the two percentiles of 4,000 samples is off by about 2 % of the width (one sd).
  EXPECT_NEAR(width(mean), normal, 0.08 * normal);
  EXPECT_LT(mean.low, mean.mean);
  EXPECT_GT(mean.high, mean.mean);
  options.confidence = 0.5;
  const MeanInterval half = bootstrap_means(values, 1, one_each(n), options)[0];
  EXPECT_NEAR(width(half), 2 * 0.67449 * std::sqrt(1.0 / 12 / double(n)), 0.08 * normal);
}

TEST(Bootstrap, CopiesWithinAGroupAreNoNewEvidence) {
  const std::vector<double> values = uniform_numbers(500);
  std::vector<double> thrice;
  std::vector<std::size_t> groups;
  for (std::size_t i = 0; i < values.size(); ++i) {
    thrice.insert(thrice.end(), 3, values[i]);
    groups.insert(groups.end(), 3, 1000 - i);  // numbers of groups are only names
  }
  const MeanInterval once = bootstrap_means(values, 1, one_each(500))[0];
  const MeanInterval grouped = bootstrap_means(thrice, 1, groups)[0];
  // The same draws; sums of three equal numbers round differently.
  EXPECT_NEAR(grouped.low, once.low, 1e-12);
  EXPECT_NEAR(grouped.high, once.high, 1e-12);
  const MeanInterval apart = bootstrap_means(thrice, 1, one_each(1500))[0];
  // Narrower by sqrt(3), give or take what two percentiles of 1,000 samples vary (about 5 %).
  EXPECT_NEAR(width(grouped) / width(apart), std::sqrt(3.0), 0.25);
}

TEST(Bootstrap, GroupsOfDifferentSizesWeighWhatTheyHold) {
  // One group of three zeros, one of a single one: means of samples are 0, 1/4 (drawn once
  // each), 1.
  const std::vector<double> values{0, 0, 0, 1};
  const std::vector<std::size_t> groups{0, 0, 0, 1};
  BootstrapOptions options;
  options.confidence = 0.2;  // percentiles 40 and 60, amid the half that has 1/4
  const MeanInterval mean = bootstrap_means(values, 1, groups, options)[0];
  EXPECT_EQ(mean.mean, 0.25);
  EXPECT_EQ(mean.low, 0.25);
  EXPECT_EQ(mean.high, 0.25);
}

TEST(Bootstrap, ColumnsShareTheirDraws) {
  std::vector<double> values;
  for (const double value : uniform_numbers(100)) {
    values.push_back(value);
    values.push_back(2 * value);  // a power of two: the same bits but for the exponent
  }
  const auto means = bootstrap_means(values, 2, one_each(100));
  EXPECT_EQ(means[1].low, 2 * means[0].low);
  EXPECT_EQ(means[1].high, 2 * means[0].high);
}

TEST(Bootstrap, IsTheSameAtAnyThreadCountAndDiffersBySeed) {
  const std::vector<double> values = uniform_numbers(300);
  BootstrapOptions options;
  options.threads = 1;
  const MeanInterval one = bootstrap_means(values, 1, one_each(300), options)[0];
  options.threads = 3;
  const MeanInterval three = bootstrap_means(values, 1, one_each(300), options)[0];
  EXPECT_EQ(one.low, three.low);
  EXPECT_EQ(one.high, three.high);
  options.seed = 2;
  EXPECT_NE(bootstrap_means(values, 1, one_each(300), options)[0].low, one.low);
}

TEST(Bootstrap, InfiniteValuesGiveNoNaN) {
  std::vector<double> values = uniform_numbers(50);
  values[3] = kInfinity;
  const MeanInterval mean = bootstrap_means(values, 1, one_each(50))[0];
  EXPECT_EQ(mean.mean, kInfinity);
  EXPECT_TRUE(std::isfinite(mean.low)) << "a third of the samples is without it";
  EXPECT_EQ(mean.high, kInfinity);
}

TEST(Bootstrap, RefusesWhatHasNoAnswer) {
  const std::vector<double> values{1, 2};
  const std::vector<std::size_t> groups{0, 1};
  EXPECT_THROW(bootstrap_means({}, 1, {}), ArgumentError);
  EXPECT_THROW(bootstrap_means(values, 2, groups), ArgumentError);
  BootstrapOptions options;
  options.samples = 0;
  EXPECT_EQ(bootstrap_means(values, 1, groups, options)[0].low, 1.5);
  options.samples = -1;
  EXPECT_THROW(bootstrap_means(values, 1, groups, options), ArgumentError);
  options = {};
  options.confidence = 1;
  EXPECT_THROW(bootstrap_means(values, 1, groups, options), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
