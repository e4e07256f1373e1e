#include "enfilade/tasks/published.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "enfilade/tasks/scorer.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::Contains;
using ::testing::Field;
using ::testing::IsEmpty;
using ::testing::Not;

TEST(Published, EachRowHasASourceAndFiguresThatItsLeaderboardHasAColumnFor) {
  for (const PublishedResult& one : published_results()) {
    EXPECT_FALSE(one.source.empty()) << one.agent;
    const Benchmark& of = benchmark(one.benchmark);
    std::size_t count = 0;
    for (const PublishedFigure& figure : one.figures) {
      if (figure.column.empty()) continue;
      ++count;
      const auto columns = of.scorers.front().columns;
      const auto column = std::ranges::find_if(
          columns, [&](const Measure& m) { return m.column == figure.column; });
      ASSERT_NE(column, columns.end()) << one.agent << " " << figure.column;
      const double most = column->unit == Unit::kShare ? 1 : 30;
      EXPECT_GE(figure.value, 0) << one.agent;
      EXPECT_LE(figure.value, most) << one.agent << " " << figure.column;
    }
    EXPECT_GT(count, 0U) << one.agent;
  }
}

TEST(Published, StandsBesideTheSplitThatItIsOf) {
  const Benchmark& r2r = benchmark("r2r");
  const auto test = published_beside(r2r, "test", 4173, false);
  EXPECT_THAT(test, Contains(Field(&PublishedResult::agent, "Human")));
  const auto unseen = published_beside(r2r, "val_unseen", 2349, false);
  EXPECT_THAT(unseen, Contains(Field(&PublishedResult::agent, "NaviLLM")));
  EXPECT_THAT(unseen, Not(Contains(Field(&PublishedResult::agent, "Human"))));
  EXPECT_THAT(unseen, Not(Contains(Field(&PublishedResult::agent, "Shortest"))));
  EXPECT_THAT(published_beside(benchmark("reverie"), "val_unseen", 3521, false),
              Contains(Field(&PublishedResult::agent, "NaviLLM")));
}

TEST(Published, StandsBesideNoOtherData) {
  const Benchmark& r2r = benchmark("r2r");
  EXPECT_THAT(published_beside(r2r, "val_unseen", 54, false), IsEmpty()) << "not R2R's split";
  EXPECT_THAT(published_beside(r2r, "val_unseen", 2349, true), IsEmpty()) << "model homes";
  EXPECT_THAT(published_beside(r2r, "train", 14025, false), IsEmpty());
  EXPECT_THAT(published_beside(benchmark("soon"), "val_unseen_house", 100, false), IsEmpty());
}

TEST(Published, AFigureIsFoundByItsColumn) {
  const auto test = published_beside(benchmark("r2r"), "test", 4173, false);
  const auto human = std::ranges::find(test, std::string_view("Human"), &PublishedResult::agent);
  ASSERT_NE(human, test.end());
  EXPECT_EQ(human->value("NE"), 1.61);
  EXPECT_EQ(human->value("SPL"), std::nullopt);
  EXPECT_EQ(human->value(""), std::nullopt);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
