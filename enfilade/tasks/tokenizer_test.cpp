#include "enfilade/tasks/tokenizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/annotations.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tasks {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Tokenize, SplitsWordsFromPunctuation) {
  EXPECT_THAT(tokenize("Walk past the table. Stop!"),
              ElementsAre("walk", "past", "the", "table", ".", "stop", "!"));
  EXPECT_THAT(tokenize("the owner's TV-room"),
              ElementsAre("the", "owner", "'", "s", "tv", "-", "room"));
  EXPECT_THAT(tokenize("2nd door"), ElementsAre("2nd", "door"));
}

TEST(Tokenize, DropsSpaceOfAnyKind) {
  EXPECT_THAT(tokenize(""), IsEmpty());
  EXPECT_THAT(tokenize(" \t\r\n\v\f"), IsEmpty());
  EXPECT_THAT(tokenize("  go\r\n\n on "), ElementsAre("go", "on"));
}

TEST(Tokenize, PunctuationComesApartButForFullStops) {
  EXPECT_THAT(tokenize("go?!"), ElementsAre("go", "?", "!"));
  EXPECT_THAT(tokenize("wait...go"), ElementsAre("wait", "...", "go"));
  EXPECT_THAT(tokenize("wait.,"), ElementsAre("wait", ".", ","));
  EXPECT_THAT(tokenize("a / b"), ElementsAre("a", "/", "b"));
  EXPECT_THAT(tokenize("a_b __"), ElementsAre("a_b", "_", "_")) << "_ is a letter, and punctuation";
}

// Not what one would design, but what the released vocabulary was counted with.
TEST(Tokenize, PunctuationWithSpaceInsideStaysTogether) {
  EXPECT_THAT(tokenize("left. (The"), ElementsAre("left", ". (", "the"));
  EXPECT_THAT(tokenize("left . . go"), ElementsAre("left", ". .", "go"));
}

TEST(Tokenize, BytesAboveAsciiAreLetters) {
  EXPECT_THAT(tokenize("Caf\xC3\x89 bar"), ElementsAre("caf\xC3\x89", "bar"));
}

Vocabulary small_vocabulary() {
  // the: 3, go: 2, b and a: 1 each.
  const std::vector<std::string> texts{"Go the b", "the the", "go a"};
  return Vocabulary::build(texts, 1);
}

TEST(Vocabulary, OrdersWordsByCountThenAlphabet) {
  EXPECT_THAT(small_vocabulary().words(),
              ElementsAre("<PAD>", "<UNK>", "<EOS>", "the", "go", "a", "b"));
  const std::vector<std::string> texts{"Go the b", "the the", "go a"};
  EXPECT_THAT(Vocabulary::build(texts, 2).words(),
              ElementsAre("<PAD>", "<UNK>", "<EOS>", "the", "go"));
  EXPECT_EQ(small_vocabulary().id("go"), 4U);
  EXPECT_EQ(small_vocabulary().id("Go"), Vocabulary::kUnknown) << "tokens are lower case";
}

TEST(Vocabulary, EncodesReversed) {
  const Vocabulary v = small_vocabulary();
  EXPECT_THAT(v.encode("Go the X", 6), ElementsAre(1, 3, 4, 2, 0, 0));
  EXPECT_THAT(v.encode("Go the X", 2), ElementsAre(1, 3)) << "the beginning and <EOS> are lost";
  EXPECT_THAT(v.encode("", 2), ElementsAre(2, 0));
  EXPECT_EQ(v.encode("go").size(), 80U);
}

TEST(Vocabulary, DecodesInReadingOrder) {
  const Vocabulary v = small_vocabulary();
  EXPECT_EQ(v.decode(v.encode("Go the x b")), "go the <UNK> b");
  const std::vector<std::uint32_t> foreign{99, 3};
  EXPECT_EQ(v.decode(foreign), "the <UNK>");
}

class VocabularyFileTest : public ::testing::Test {
 protected:
  std::string faults_of(const std::string& content) {
    write_file_atomically(file_, content);
    try {
      Vocabulary::load(file_);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "accepted";
  }

  const tests::TemporaryFolder folder_{"vocabulary"};
  const fs::path file_ = folder_.path() / "vocabulary.txt";
};

TEST_F(VocabularyFileTest, ReadsWhatItWrites) {
  small_vocabulary().save(file_);
  EXPECT_EQ(Vocabulary::load(file_).words(), small_vocabulary().words());
  EXPECT_EQ(faults_of("<PAD>\r\n<UNK>\r\n<EOS>\r\nthe"), "accepted");
  EXPECT_EQ(Vocabulary::load(file_).id("the"), 3U);
  EXPECT_EQ(faults_of("\xEF\xBB\xBF<PAD>\r\n<UNK>\r\n<EOS>\r\nthe\r\n\r\n\r\n"), "accepted");
  EXPECT_EQ(Vocabulary::load(file_).size(), 4U);
}

TEST_F(VocabularyFileTest, NamesLineAndWhatIsAllowed) {
  EXPECT_THAT(faults_of("<PAD>\n<EOS>\n<UNK>\n"), HasSubstr("line 2: \"<EOS>\", not \"<UNK>\""));
  EXPECT_THAT(faults_of("<PAD>\n"), HasSubstr("1 lines; the first three must be <PAD>, <UNK>"));
  EXPECT_THAT(faults_of("<PAD>\n<UNK>\n<EOS>\na\na\n"),
              HasSubstr("line 5: \"a\" stands in line 4 already"));
  EXPECT_THAT(faults_of("<PAD>\n<UNK>\n<EOS>\n\na\n"), HasSubstr("line 4: no word"));
  EXPECT_THROW(Vocabulary::load("/nonexistent/vocabulary.txt"), FileError);
}

std::vector<std::string> instructions(const scan::DataRoot& data,
                                      const std::vector<std::string>& splits) {
  std::vector<std::string> texts;
  for (const std::string& split : splits) {
    for (const auto& path : load_annotations(data.annotations(split), split).paths) {
      texts.insert(texts.end(), path.instructions.begin(), path.instructions.end());
    }
  }
  return texts;
}

TEST(Vocabulary, IsMadeOfItsWords) {
  const Vocabulary vocabulary = Vocabulary::of({"<PAD>", "<UNK>", "<EOS>", "walk"});
  EXPECT_EQ(vocabulary.id("walk"), 3U);
  EXPECT_EQ(Vocabulary::of(vocabulary.words()).words(), vocabulary.words());
  EXPECT_THROW(Vocabulary::of({"walk"}), InvalidInput);
}

TEST(Vocabulary, OfRealInstructions) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real annotations";
  const auto all = instructions(*data, {"train", "val_seen", "val_unseen", "test"});
  // "3.1k words, 1.2k of them with five or more mentions" (the paper, section 4.3).
  EXPECT_EQ(Vocabulary::build(all, 1).size() - 3, 3141U);
  EXPECT_EQ(Vocabulary::build(all, 5).size() - 3, 1192U);
  const auto train = instructions(*data, {"train"});
  EXPECT_EQ(train.size(), 14039U);
  EXPECT_EQ(Vocabulary::build(train, 5).size(), 991U);
}

TEST(Vocabulary, IsTheReleasedOne) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no released vocabulary";
  const fs::path file = data->folder() / "vocab" / "train_vocab.txt";
  if (!fs::exists(file)) GTEST_SKIP() << file << " is missing: no released vocabulary";
  const Vocabulary released = Vocabulary::load(file);
  const Vocabulary built = Vocabulary::build(instructions(*data, {"train"}));
  // As sets: the released order of words that are equally frequent cannot be reproduced.
  EXPECT_EQ(std::set(built.words().begin(), built.words().end()),
            std::set(released.words().begin(), released.words().end()));
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
