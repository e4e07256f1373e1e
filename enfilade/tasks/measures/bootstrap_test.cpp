#include "enfilade/tasks/bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
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

// Normal numbers, by Box and Muller.
std::vector<double> normal_numbers(std::size_t n, Rng& rng) {
  std::vector<double> values(n);
  for (double& value : values) {
    const double radius = std::sqrt(-2 * std::log(1 - rng.uniform()));
    value = radius * std::cos(2 * std::numbers::pi * rng.uniform());
  }
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

TEST(PairedBootstrap, EqualResultsHaveNoDifference) {
  std::vector<double> values = uniform_numbers(60);
  values[7] = kInfinity;  // an unreachable goal, in both
  const PairedDifference one = paired_bootstrap(values, values, 1, one_each(60))[0];
  EXPECT_EQ(one.difference.mean, 0);
  EXPECT_EQ(one.difference.low, 0);
  EXPECT_EQ(one.difference.high, 0);
  EXPECT_EQ(one.p, 1);
}

TEST(PairedBootstrap, AConstantDifferenceIsCertain) {
  const std::vector<double> first = uniform_numbers(60);
  std::vector<double> second = first;
  for (double& value : second) value += 0.25;
  const PairedDifference one = paired_bootstrap(first, second, 1, one_each(60))[0];
  EXPECT_NEAR(one.difference.mean, 0.25, 1e-12);
  EXPECT_NEAR(one.difference.low, 0.25, 1e-12);
  EXPECT_NEAR(one.difference.high, 0.25, 1e-12);
  EXPECT_EQ(one.p, 0);
}

TEST(PairedBootstrap, TheOtherOrderTurnsTheSign) {
  const std::vector<double> first = uniform_numbers(60);
  std::vector<double> second = first;
  for (std::size_t i = 0; i < second.size(); ++i) second[i] += i % 3 == 0 ? -0.2 : 0.15;
  const PairedDifference one = paired_bootstrap(first, second, 1, one_each(60))[0];
  const PairedDifference other = paired_bootstrap(second, first, 1, one_each(60))[0];
  EXPECT_NEAR(one.difference.mean, (20 * -0.2 + 40 * 0.15) / 60, 1e-12);
  EXPECT_NEAR(other.difference.low, -one.difference.high, 1e-12);
  EXPECT_NEAR(other.difference.high, -one.difference.low, 1e-12);
  EXPECT_EQ(other.p, one.p);
  EXPECT_GT(one.p, 0);
  EXPECT_LT(one.p, 0.2) << "0.033 with an sd of 0.165 / sqrt(60): 1.57 sd away from zero";
}

TEST(PairedBootstrap, TwoEpisodesAreCountedExactly) {
  // Draws have the mean 1 (a quarter of them), 0 (half) or -1: three quarters on each side.
  const std::vector<double> first{0, 1}, second{1, 0};
  const PairedDifference one =
      paired_bootstrap(first, second, 1, std::vector<std::size_t>{0, 1})[0];
  EXPECT_EQ(one.difference.mean, 0);
  EXPECT_EQ(one.difference.low, -1);
  EXPECT_EQ(one.difference.high, 1);
  EXPECT_EQ(one.p, 1);
  // One of n episodes differs. It is in no draw with the probability (1 - 1/n)^n, 0.343 of 8.
  std::vector<double> better(8, 0);
  better[3] = 1;
  BootstrapOptions options;
  options.samples = 20000;
  const PairedDifference rare =
      paired_bootstrap(std::vector<double>(8, 0), better, 1, one_each(8), options)[0];
  EXPECT_NEAR(rare.p, 2 * std::pow(7.0 / 8, 8), 0.03);
  EXPECT_EQ(rare.difference.low, 0);
}

TEST(PairedBootstrap, IsTheIntervalOfTheDifferencesThatPairsHave) {
  const std::vector<double> first = uniform_numbers(90);
  Rng rng(11);
  std::vector<double> second, differences;
  std::vector<std::size_t> groups;
  for (std::size_t i = 0; i < first.size(); ++i) {
    second.push_back(first[i] + rng.uniform() - 0.5);
    differences.push_back(second[i] - first[i]);
    groups.push_back(i / 3);
  }
  const MeanInterval paired = paired_bootstrap(first, second, 1, groups)[0].difference;
  const MeanInterval alone = bootstrap_means(differences, 1, groups)[0];
  EXPECT_EQ(paired.mean, alone.mean);
  EXPECT_EQ(paired.low, alone.low);
  EXPECT_EQ(paired.high, alone.high);
}

TEST(PairedBootstrap, CopiesWithinAGroupMakeNothingMoreCertain) {
  Rng rng(5);
  std::vector<double> once = normal_numbers(40, rng);
  const double mean = std::accumulate(once.begin(), once.end(), 0.0) / 40;
  for (double& value : once) value += 0.25 - mean;  // 1.6 sd away from zero
  std::vector<double> thrice;
  std::vector<std::size_t> groups;
  for (std::size_t i = 0; i < once.size(); ++i) {
    thrice.insert(thrice.end(), 3, once[i]);
    groups.insert(groups.end(), 3, i);
  }
  const auto p = [](const std::vector<double>& second, const std::vector<std::size_t>& drawn) {
    return paired_bootstrap(std::vector<double>(second.size(), 0), second, 1, drawn)[0].p;
  };
  EXPECT_EQ(p(thrice, groups), p(once, one_each(40)));
  EXPECT_LT(p(thrice, one_each(120)), p(once, one_each(40)));
}

TEST(PairedBootstrap, ThreadsNeverChangeAResultAndColumnsShareTheirDraws) {
  std::vector<double> first, second;
  Rng rng(3);
  for (const double value : uniform_numbers(200)) {
    first.insert(first.end(), {value, 2 * value});
    const double other = rng.uniform();
    second.insert(second.end(), {other, 2 * other});
  }
  BootstrapOptions options;
  options.threads = 1;
  const auto one = paired_bootstrap(first, second, 2, one_each(200), options);
  options.threads = 3;
  const auto three = paired_bootstrap(first, second, 2, one_each(200), options);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_EQ(one[c].difference.low, three[c].difference.low);
    EXPECT_EQ(one[c].difference.high, three[c].difference.high);
    EXPECT_EQ(one[c].p, three[c].p);
  }
  EXPECT_EQ(one[1].difference.low, 2 * one[0].difference.low);
  EXPECT_EQ(one[1].p, one[0].p);
}

TEST(PairedBootstrap, CoversTheTrueDifferenceAsOftenAsItSays) {
  // Pairs that are strongly correlated, as two agents on one episode are; true difference 0.1.
  constexpr std::size_t kStudies = 1000, kPairs = 60;
  constexpr double kTrue = 0.1;
  BootstrapOptions options;
  options.samples = 400;
  options.threads = 1;
  std::size_t covered = 0, rejected = 0;
  double paired_width = 0, apart_width = 0;
  for (std::size_t study = 0; study < kStudies; ++study) {
    Rng rng(17, study);
    const std::vector<double> first = normal_numbers(kPairs, rng);
    const std::vector<double> noise = normal_numbers(kPairs, rng);
    std::vector<double> second(kPairs), equal(kPairs);
    for (std::size_t i = 0; i < kPairs; ++i) {
      equal[i] = first[i] + 0.5 * noise[i];
      second[i] = equal[i] + kTrue;
    }
    options.seed = study;
    const MeanInterval found =
        paired_bootstrap(first, second, 1, one_each(kPairs), options)[0].difference;
    if (found.low <= kTrue && kTrue <= found.high) ++covered;
    if (paired_bootstrap(first, equal, 1, one_each(kPairs), options)[0].p < 0.05) ++rejected;
    paired_width += width(found);
    apart_width += width(bootstrap_means(second, 1, one_each(kPairs), options)[0]);
  }
  // The percentile interval of 60 values is too narrow by some 1 %; one sd of a share is 0.7 %.
  EXPECT_NEAR(double(covered) / kStudies, 0.94, 0.025);
  EXPECT_NEAR(double(rejected) / kStudies, 0.06, 0.025);
  EXPECT_LT(paired_width, 0.6 * apart_width) << "pairs tell more than two intervals do";
}

// Some numbers of draws put an end of the interval between -inf and a finite mean.
TEST(PairedBootstrap, AnInfiniteImprovementIsTheMirrorImageOfAnInfiniteLoss) {
  const std::vector<double> reached = uniform_numbers(5);
  std::vector<double> lost = reached;
  lost[2] = kInfinity;
  const auto expect_mirrored = [](double value, double mirrored, int samples) {
    ASSERT_FALSE(std::isnan(value)) << samples << " draws";
    if (std::isinf(mirrored)) {
      EXPECT_EQ(value, -mirrored) << samples << " draws";
    } else {
      EXPECT_NEAR(value, -mirrored, 1e-12) << samples << " draws";
    }
  };
  BootstrapOptions options;
  for (options.samples = 2; options.samples <= 30; ++options.samples) {
    const PairedDifference better = paired_bootstrap(lost, reached, 1, one_each(5), options)[0];
    const PairedDifference worse = paired_bootstrap(reached, lost, 1, one_each(5), options)[0];
    EXPECT_EQ(better.difference.mean, -kInfinity);
    expect_mirrored(better.difference.low, worse.difference.high, options.samples);
    expect_mirrored(better.difference.high, worse.difference.low, options.samples);
    EXPECT_EQ(better.p, worse.p) << options.samples << " draws";
  }
}

TEST(PairedBootstrap, InfiniteDifferencesOfBothSignsHaveNoOrder) {
  std::vector<double> first = uniform_numbers(20), second = first;
  second[2] = kInfinity;
  const PairedDifference worse = paired_bootstrap(first, second, 1, one_each(20))[0];
  EXPECT_EQ(worse.difference.mean, kInfinity);
  EXPECT_EQ(worse.difference.high, kInfinity);
  first[4] = kInfinity;
  const PairedDifference both = paired_bootstrap(first, second, 1, one_each(20))[0];
  EXPECT_TRUE(std::isnan(both.difference.mean));
  EXPECT_EQ(both.difference.low, -kInfinity);
  EXPECT_EQ(both.difference.high, kInfinity);
  EXPECT_EQ(both.p, 1);
}

TEST(PairedBootstrap, RefusesWhatHasNoAnswer) {
  const std::vector<double> two{1, 2}, three{1, 2, 3};
  const std::vector<std::size_t> groups{0, 1};
  EXPECT_THROW(paired_bootstrap({}, {}, 1, {}), ArgumentError);
  EXPECT_THROW(paired_bootstrap(two, three, 1, groups), ArgumentError);
  EXPECT_THROW(paired_bootstrap(three, two, 1, groups), ArgumentError);
  BootstrapOptions options;
  options.confidence = 0;
  EXPECT_THROW(paired_bootstrap(two, two, 1, groups, options), ArgumentError);
  options = {};
  options.samples = 0;
  const PairedDifference one =
      paired_bootstrap(two, std::vector<double>{2, 4}, 1, groups, options)[0];
  EXPECT_EQ(one.difference.low, 1.5);
  EXPECT_EQ(one.difference.high, 1.5);
  EXPECT_EQ(one.p, 1);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
