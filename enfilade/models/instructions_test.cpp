#include "enfilade/models/instruction_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"

namespace enfilade::models {
namespace EN_UNIT {

using ::testing::ElementsAre;

tasks::EpisodeSet episodes_of(const std::vector<std::string>& texts) {
  tasks::EpisodeSet set{"made", graph::GraphSet::of({}), {}, {}};
  for (const std::string& text : texts) {
    set.episodes.push_back({tasks::instruction_id(1, set.episodes.size()), 0, 0, text});
  }
  return set;
}

TEST(TrainingVocabulary, KeepsWordsThatOccurOftenEnough) {
  const tasks::EpisodeSet set = episodes_of({"go left go", "go right left"});
  EXPECT_THAT(training_vocabulary(set, 2).words(),
              ElementsAre("<PAD>", "<UNK>", "<EOS>", "go", "left"));
}

TEST(EncodedInstructions, GathersRowsInTheOrderAskedFor) {
  const tasks::EpisodeSet set = episodes_of({"go left", "stop"});
  const tasks::Vocabulary words = training_vocabulary(set, 1);  // go 3, left 4, stop 5
  const EncodedInstructions encoded(set, words, 4);
  EXPECT_EQ(encoded.size(), 2U);
  EXPECT_THAT(encoded.row(0), ElementsAre(4, 3, 2, 0));
  std::vector<std::uint32_t> out(12);
  encoded.gather(std::vector<std::size_t>{1, 0, 1}, out);
  EXPECT_THAT(out, ElementsAre(5, 2, 0, 0, 4, 3, 2, 0, 5, 2, 0, 0));
}

TEST(ReadingOrder, TurnsWordsRoundAndPutsTheEndLast) {
  const tasks::EpisodeSet set = episodes_of({"go left", "go up left"});
  const tasks::Vocabulary words = training_vocabulary(set, 2);
  const EncodedInstructions encoded(set, words, 4);
  const ReadingOrder order = reading_order(encoded.row(1), words);
  EXPECT_THAT(order.words, ElementsAre("go", "<UNK>", "left", "<EOS>"));
  EXPECT_THAT(order.places, ElementsAre(2, 1, 0, 3));
}

TEST(ReadingOrder, HasNoEndWhereItWasCutOff) {
  const tasks::EpisodeSet set = episodes_of({"a b c d"});
  const tasks::Vocabulary words = training_vocabulary(set, 1);
  const EncodedInstructions encoded(set, words, 3);
  const ReadingOrder order = reading_order(encoded.row(0), words);
  EXPECT_THAT(order.words, ElementsAre("b", "c", "d"));
  EXPECT_THAT(order.places, ElementsAre(2, 1, 0));
}

// Sizes as the recipe has them.
TEST(RealData, TrainingEpisodesAndVocabulariesHaveTheirKnownSizes) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no R2R annotations";
  const auto graphs = graph::GraphSet::open(data->connectivity());
  const tasks::EpisodeSet set =
      make_episodes(tasks::load_annotations(data->annotations("train"), "train"), graphs,
                    tasks::Instructions::kAll);
  EXPECT_EQ(set.episodes.size(), 14'039U);
  EXPECT_EQ(training_vocabulary(set).size(), 991U);
  const tasks::Vocabulary words = training_vocabulary(set);
  const EncodedInstructions encoded(set, words);
  std::size_t long_ones = 0;
  for (std::size_t i = 0; i < encoded.size(); ++i) {
    long_ones += encoded.row(i).back() != tasks::Vocabulary::kPad &&
                         encoded.row(i).back() != tasks::Vocabulary::kEnd
                     ? 1
                     : 0;
  }
  EXPECT_EQ(long_ones, 80U);  // of 80 tokens or more
}

}  // namespace EN_UNIT
}  // namespace enfilade::models
