#include "enfilade/tasks/tokenizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(InstructionTokens, AreTheWordsAndWhatIsBetweenThem) {
  EXPECT_THAT(tokenize_continuous("Walk past the CHAIR, then stop. "),
              ElementsAre("walk", "past", "the", "chair", "then", "stop", "."));
  EXPECT_THAT(tokenize_continuous("a U-turn (left)..."),
              ElementsAre("a", "u-turn", "(", "left", ")..."));
  EXPECT_THAT(tokenize_continuous("the owner's room.'s"),
              ElementsAre("the", "owner", "'", "s", "room", ". '", "s"));
  EXPECT_THAT(tokenize_continuous("here,there?now"), ElementsAre("heretherenow"));
  EXPECT_THAT(tokenize_continuous("Stra\xC3\x9F"
                                  "e 7_b"),
              ElementsAre("stra\xC3\x9F"
                          "e",
                          "7_b"));
  EXPECT_THAT(tokenize_continuous(" ,? "), IsEmpty());
}

TEST(InstructionTokens, ArePaddedCutAndUnknown) {
  InstructionVocabulary vocabulary;
  vocabulary.words = {"<pad>", "<unk>", "go", "."};
  const InstructionEncoder encoder(vocabulary);
  EXPECT_THAT(encoder.encode("Go on.", 5), ElementsAre(2, 1, 3, 0, 0));
  EXPECT_THAT(encoder.encode("Go on.", 2), ElementsAre(2, 1));
  EXPECT_EQ(encoder.encode("").size(), 200U);
  vocabulary.unknown = 3;
  vocabulary.padding = 1;
  EXPECT_THAT(InstructionEncoder(vocabulary).encode("Go on", 3), ElementsAre(2, 3, 1));
}

TEST(InstructionTokens, NeedWordsThatAreThereOnce) {
  InstructionVocabulary vocabulary;
  const auto refusal = [&vocabulary] {
    return tests::refusal<ArgumentError>([&] { InstructionEncoder{vocabulary}; });
  };
  EXPECT_THAT(refusal(), HasSubstr("words: 0, not from 1"));
  vocabulary.words = {"go", "on", "go"};
  EXPECT_THAT(refusal(), HasSubstr("word \"go\" is there twice; the first is token 0"));
  vocabulary.words = {"go"};
  vocabulary.unknown = -1;
  EXPECT_THAT(refusal(), HasSubstr("UNK_INDEX: -1"));
}

TEST(InstructionTokens, AreThoseOfAllRealFiles) {
  const auto data = scan::DataRoot::from_environment();
  if (!data || !std::filesystem::exists(data->folder() / "vlnce")) {
    GTEST_SKIP() << "ENFILADE_DATA is not set, or has no files of VLN-CE: vlnce/*.json.gz";
  }
  std::size_t instructions = 0;
  for (const char* split : {"train", "val_seen", "val_unseen", "test"}) {
    const auto file = data->folder() / "vlnce" / (std::string(split) + ".json.gz");
    const auto all = load_continuous_episodes(file, split);
    const InstructionEncoder encoder(*all.vocabulary);
    for (const ContinuousEpisode& one : all.episodes) {
      EXPECT_EQ(encoder.encode(one.instruction.text), *one.instruction.tokens)
          << one.instruction.text;
      ++instructions;
    }
  }
  EXPECT_EQ(instructions, 16844U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
