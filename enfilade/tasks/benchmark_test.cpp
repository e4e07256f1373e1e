#include "enfilade/tasks/benchmark.h"

#include <gmock/gmock.h>
#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/scorer.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::vector<std::string> texts_of(const std::vector<std::filesystem::path>& places) {
  std::vector<std::string> texts;
  for (const auto& place : places) texts.push_back(place.string());
  return texts;
}

TEST(Benchmarks, AreFoundByNameAndByTask) {
  std::vector<std::string_view> names;
  for (const Benchmark& one : benchmarks()) {
    names.push_back(one.name);
    EXPECT_EQ(&benchmark(one.name), &one);
    EXPECT_EQ(&benchmark(one.name, one.world), &one);
    EXPECT_EQ(&benchmark(one.task) == &one, !one.continuous());
  }
  EXPECT_THAT(names, ElementsAre("r2r", "r2r-last", "r2r-back", "r4r", "rxr", "reverie", "cvdn",
                                 "soon", "r2r-ce", "rxr-ce"));
  EXPECT_EQ(find_benchmark("r3r"), nullptr);
  EXPECT_THAT([] { benchmark("r3r"); },
              ThrowsMessage<LookupError>(HasSubstr("no task \"r3r\"; there are r2r, ")));
  EXPECT_THAT([] { benchmark("r2r-ce", WorldKind::kGraph); },
              ThrowsMessage<LookupError>("no task \"r2r-ce\"; there are r2r, r2r-last, r2r-back, "
                                         "r4r, rxr, reverie, cvdn, soon"));
  EXPECT_THAT(
      [] { benchmark("rxr", WorldKind::kContinuous); },
      ThrowsMessage<LookupError>("no continuous benchmark \"rxr\"; there are r2r-ce, rxr-ce"));
}

TEST(Benchmarks, FilesLieWhereThePublicCodeHasThem) {
  EXPECT_THAT(texts_of(episode_places(benchmark("r4r"), "train")),
              ElementsAre("r4r/R4R_train.json", "r4r/R4R_train.json.gz",
                          "R4R/annotations/R4R_train_enc.json",
                          "R4R/annotations/R4R_train_enc.json.gz", "R4R/R4R_train.json",
                          "R4R/R4R_train.json.gz", "R4R_train.json", "R4R_train.json.gz"));
  EXPECT_TRUE(expert_places(benchmark("r4r"), "train").empty());
  const Benchmark &r2r = benchmark("r2r-ce"), &rxr = benchmark("rxr-ce");
  EXPECT_EQ(episode_places(r2r, "test")[0], "vlnce/test.json.gz");
  EXPECT_EQ(episode_places(r2r, "test")[1], "vlnce/test.json");
  EXPECT_THAT(texts_of(episode_places(r2r, "test")),
              Contains("R2R_VLNCE_v1-3_preprocessed/test/test.json.gz"));
  EXPECT_THAT(
      texts_of(episode_places(r2r, "train", "bertidx")),
      Contains("data/datasets/R2R_VLNCE_v1-2_preprocessed_BERTidx/train/train_bertidx.json.gz"));
  EXPECT_THAT(texts_of(episode_places(rxr, "train", "follower")),
              Contains("RxR_VLNCE_v0/train/train_follower.json.gz"));
  EXPECT_THAT(texts_of(expert_places(rxr, "train")),
              Contains("RxR_VLNCE_v0/train/train_guide_gt.json.gz"));
  EXPECT_EQ(expert_places(r2r, "train", "bertidx"), expert_places(r2r, "train"));
  EXPECT_EQ(expert_places(r2r, "val_seen")[0], "vlnce/val_seen_gt.json.gz");
  EXPECT_EQ(expert_places(r2r, "val_seen")[1], "vlnce/val_seen_gt.json");
  EXPECT_THROW(episode_places(r2r, "train", "follower"), LookupError);
}

TEST(Benchmarks, TheTestSplitIsFoundByOneNameWhateverItsFileIsCalled) {
  const Benchmark& cvdn = benchmark("cvdn");
  const auto places = texts_of(episode_places(cvdn, "test"));
  EXPECT_EQ(places.front(), "cvdn/test.json");
  EXPECT_THAT(places, Contains("cvdn/test_cleaned.json.gz"));
  EXPECT_EQ(episode_places(cvdn, "test_cleaned").front(), "cvdn/test_cleaned.json");
  EXPECT_EQ(split_name(cvdn, "test_cleaned"), "test");
  EXPECT_EQ(split_name(cvdn, "val_seen"), "val_seen");
  EXPECT_EQ(split_name(benchmark("r2r"), "test_cleaned"), "test_cleaned");
  EXPECT_EQ(split_name(benchmark("r2r"), ""), "");
}

TEST(Benchmarks, FilesArePackedOrPlainWhereverTheyLie) {
  for (const Benchmark& of : benchmarks()) {
    for (const auto& places : {episode_places(of, "val_seen"), expert_places(of, "val_seen")}) {
      const auto texts = texts_of(places);
      for (const std::string& one : texts) {
        const bool packed = one.ends_with(".gz");
        const std::string other = packed ? one.substr(0, one.size() - 3) : one + ".gz";
        EXPECT_THAT(texts, Contains(other));
      }
    }
  }
}

TEST(Measures, AreMeansOfTheirScorers) {
  for (const Benchmark& of : benchmarks()) {
    for (const Scorer& scorer : of.scorers) {
      for (const Measure& one : scorer.columns) {
        const auto& metric = scorer.metrics[scorer.place_of(one.name)];
        EXPECT_NE(metric.rule, MeanRule::kNone) << one.name;
        EXPECT_EQ(metric.scale, one.whole) << scorer.name << " " << one.name;
      }
    }
  }
}

TEST(Measures, EachScorerHasThemOnceWithAHeadline) {
  for (const Benchmark& of : benchmarks()) {
    EXPECT_NO_THROW(of.scorer(of.table_scorer)) << of.name;
    for (const Scorer& scorer : of.scorers) {
      std::set<std::string> names;
      std::set<std::string> columns;
      for (const Measure& one : scorer.columns) {
        EXPECT_TRUE(names.insert(one.name).second) << one.name;
        EXPECT_TRUE(columns.insert(one.column).second) << one.column;
        EXPECT_EQ(one.tells_goals, one.better != Better::kNeither) << one.name;
        EXPECT_EQ(find_measure(scorer.columns, one.name), &one);
      }
      EXPECT_EQ(scorer.columns.front().better, Better::kHigher) << scorer.name;
    }
  }
  EXPECT_EQ(find_measure(own_scorer().columns, "gp"), nullptr);
}

TEST(Measures, HeadlinesAreThoseOfTheBenchmarks) {
  std::vector<std::string> columns;
  for (const Benchmark& one : benchmarks()) columns.emplace_back(one.headline().column);
  EXPECT_THAT(columns, ElementsAre("SPL", "SPL", "SPL", "sDTW", "nDTW", "RGSPL", "GP", "FSPL",
                                   "SPL", "nDTW"));
  EXPECT_EQ(benchmark(Task::kCvdn).headline().unit, Unit::kMetres);
}

TEST(Measures, AnUnknownScorerIsRefusedWithThoseThatThereAre) {
  EXPECT_THAT([] { benchmark(Task::kSoon).scorer("hamt"); },
              ThrowsMessage<LookupError>(
                  HasSubstr("no scorer \"hamt\" for SOON; there are duet, official")));
  EXPECT_THROW(benchmark(Task::kReverie).scorer(kOwnScorer), LookupError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
