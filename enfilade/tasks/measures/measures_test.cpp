#include "enfilade/tasks/measures.h"

#include <gmock/gmock.h>
#include <algorithm>
#include <set>
#include <string>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/public_scorer.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr auto kTasks = std::to_array<Task>({Task::kR2r, Task::kR2rLast, Task::kR2rBack, Task::kR4r,
                                             Task::kRxr, Task::kReverie, Task::kCvdn, Task::kSoon});

TEST(Measures, AreMeansOfTheirScorers) {
  for (const PublicScorer& scorer : public_scorers()) {
    for (const Measure& one : measures(scorer.task, scorer.name)) {
      const auto metric =
          std::ranges::find(scorer.metrics, std::string_view(one.name), &ScorerMetric::mean_name);
      ASSERT_NE(metric, scorer.metrics.end()) << scorer.name << " " << one.name;
      EXPECT_NE(metric->rule, MeanRule::kNone) << one.name;
      EXPECT_EQ(metric->scale, one.whole) << scorer.name << " " << one.name;
    }
  }
  for (const Measure& one : measures(Task::kR2r)) {
    EXPECT_TRUE(std::ranges::any_of(metric_fields(), [&](const MetricField& field) {
      return std::string_view(field.name) == one.name;
    })) << one.name;
    EXPECT_EQ(one.whole, 1);
  }
}

TEST(Measures, EachScorerOfATaskHasThemWithItsDefaultFirst) {
  for (const Task task : kTasks) {
    std::vector<std::string_view> expected;
    if (task == Task::kR2r) expected.push_back(kOwnScorer);
    for (const PublicScorer& scorer : public_scorers(task)) expected.push_back(scorer.name);
    EXPECT_EQ(scorer_names(task), expected);
    EXPECT_EQ(measures(task).data(), measures(task, expected.front()).data());
    for (const std::string_view scorer : expected) {
      std::set<std::string> names;
      std::set<std::string> columns;
      for (const Measure& one : measures(task, scorer)) {
        EXPECT_TRUE(names.insert(one.name).second) << one.name;
        EXPECT_TRUE(columns.insert(one.column).second) << one.column;
        EXPECT_EQ(one.tells_goals, one.better != Better::kNeither) << one.name;
        EXPECT_EQ(find_measure(measures(task, scorer), one.name), &one);
      }
      EXPECT_EQ(measures(task, scorer).front().better, Better::kHigher) << scorer;
    }
  }
  EXPECT_EQ(find_measure(measures(Task::kR2r), "gp"), nullptr);
}

TEST(Measures, HeadlinesAreThoseOfTheBenchmarks) {
  std::vector<std::string> columns;
  for (const Task task : kTasks) columns.emplace_back(headline(task).column);
  EXPECT_THAT(columns, ElementsAre("SPL", "SPL", "SPL", "sDTW", "nDTW", "RGSPL", "GP", "FSPL"));
  EXPECT_EQ(headline(Task::kCvdn).unit, Unit::kMetres);
}

TEST(Measures, AnUnknownScorerIsRefusedWithThoseThatThereAre) {
  EXPECT_THAT([] { measures(Task::kSoon, "hamt"); },
              ThrowsMessage<LookupError>(
                  HasSubstr("no scorer \"hamt\" for SOON; there are duet, official")));
  EXPECT_THROW(measures(Task::kReverie, kOwnScorer), LookupError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
