#include "enfilade/models/instruction_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace enfilade::models {
namespace EN_UNIT {

using ::testing::ElementsAre;

tasks::Vocabulary five_words() {
  return tasks::Vocabulary::of({"<PAD>", "<UNK>", "<EOS>", "go", "left"});
}

TEST(InstructionWords, WordsAreReadInTheirOrderBetweenTwoMarks) {
  const InstructionWords words(five_words());
  EXPECT_EQ(words.size(), 7U);
  EXPECT_THAT(words.encode("Go right, left", 10), ElementsAre(5, 3, 1, 1, 4, 2));
  EXPECT_THAT(words.encode("", 10), ElementsAre(5, 2)) << "what an agent without language reads";
  EXPECT_EQ(words.word(3), "go");
  EXPECT_EQ(words.word(words.begin()), "<BOS>");
  EXPECT_EQ(words.mask(), 6);
  EXPECT_EQ(words.word(6), "<MASK>");
}

TEST(InstructionWords, ALongInstructionKeepsItsBeginningAndItsEndMark) {
  const InstructionWords words(five_words());
  EXPECT_THAT(words.encode("go left go left", 4), ElementsAre(5, 3, 4, 2));
  const InstructionWords more(
      tasks::Vocabulary::of({"<PAD>", "<UNK>", "<EOS>", "walk", "past", "the"}));
  EXPECT_THAT(more.encode("Walk past the table", 80), ElementsAre(6, 3, 4, 5, 1, 2));
  EXPECT_THAT(more.encode("Walk past the table", 4), ElementsAre(6, 3, 4, 2));
}

TEST(InstructionWords, PiecesAreThoseOfTheReleasedVocabulary) {
  const InstructionWords words(
      Subwords::parse_word_pieces("[PAD]\n[UNK]\n[CLS]\n[SEP]\n[MASK]\ngo\nle\n##ft\n", "vocab"));
  EXPECT_EQ(words.size(), 8U);
  EXPECT_THAT(words.encode("Go left", 10), ElementsAre(2, 5, 6, 7, 3));
  EXPECT_THAT(words.encode("Go left", 4), ElementsAre(2, 5, 6, 3));
  EXPECT_EQ(words.mask(), 4);
  EXPECT_EQ(words.pad(), 0);
  EXPECT_EQ(words.word(7), "##ft");
  EXPECT_EQ(words.vocabulary(), nullptr);
}

TEST(InstructionWords, IdsOfTheAnnotationsAreReadAsTheyAre) {
  const InstructionWords words(
      Subwords::parse_word_pieces("[PAD]\n[UNK]\n[CLS]\n[SEP]\n[MASK]\ngo\nle\n##ft\n", "vocab"));
  tasks::Episode episode;
  episode.text = "Go left";
  EXPECT_THAT(words.encode(episode, 10), ElementsAre(2, 5, 6, 7, 3)) << "there are none";
  episode.details.tokens = {2, 7, 7, 6, 3};
  EXPECT_THAT(words.encode(episode, 10), ElementsAre(2, 7, 7, 6, 3));
  EXPECT_THAT(words.encode(episode, 3), ElementsAre(2, 7, 7)) << "without an end, as published";
  episode.details.tokens = {2, 7, 8, 3};
  EXPECT_THAT(words.encode(episode, 10), ElementsAre(2, 5, 6, 7, 3)) << "8 is no id";
  episode.details.tokens = {0, 7, 2};
  EXPECT_THAT(words.encode(episode, 10), ElementsAre(2, 5, 6, 7, 3)) << "another vocabulary's";
  episode.details.tokens = {2, 7, 3};
  EXPECT_THAT(InstructionWords(five_words()).encode(episode, 10), ElementsAre(5, 3, 4, 2));
}

}  // namespace EN_UNIT
}  // namespace enfilade::models
