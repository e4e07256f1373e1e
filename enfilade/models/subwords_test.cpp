#include "enfilade/models/subwords.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/tasks/files.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::models {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// ----- WordPiece

// Ids: lines from 0.
const std::string kWords =
    "[PAD]\n[UNK]\n[CLS]\n[SEP]\n[MASK]\nwalk\n##ing\nwal\n##k\n,\nsofa\nthe\n"
    "\xE5\xB7\xA6\nWalk\n##s\ncafe\n";

// Pieces that a text becomes, without the two around it.
std::vector<std::string> pieces_of(const Subwords& words, std::string_view text) {
  const std::vector<std::int32_t> ids = words.encode(text);
  EXPECT_EQ(ids.front(), static_cast<std::int32_t>(words.begin()));
  EXPECT_EQ(ids.back(), static_cast<std::int32_t>(words.end()));
  std::vector<std::string> pieces;
  for (std::size_t k = 1; k + 1 < ids.size(); ++k) {
    pieces.emplace_back(words.piece(static_cast<std::uint32_t>(ids[k])));
  }
  return pieces;
}

TEST(WordPieces, TakeTheLongestPieceFromTheLeft) {
  const Subwords words = Subwords::parse_word_pieces(kWords, "v");
  EXPECT_EQ(words.size(), 16U);
  EXPECT_EQ(words.pad(), 0U);
  EXPECT_EQ(words.unknown(), 1U);
  EXPECT_EQ(words.mask(), 4U);
  EXPECT_EQ(words.find("sofa"), 10U);
  EXPECT_EQ(words.find("chair"), std::nullopt);
  EXPECT_THAT(words.encode("walking"), ElementsAre(2, 5, 6, 3));
  EXPECT_THAT(pieces_of(words, "walks walk, walkingk"),
              ElementsAre("walk", "##s", "walk", ",", "walk", "##ing", "##k"));
  EXPECT_THAT(pieces_of(words, "the chair walkx sofa"),
              ElementsAre("the", "[UNK]", "[UNK]", "sofa"));
  EXPECT_THAT(words.encode(""), ElementsAre(2, 3));
}

TEST(WordPieces, FoldLettersOrNot) {
  const Subwords folded = Subwords::parse_word_pieces(kWords, "v");
  EXPECT_THAT(pieces_of(folded, "Walk WALK caf\xC3\xA9 CAFE\xCC\x81"),
              ElementsAre("walk", "walk", "cafe", "cafe"));
  const Subwords cased = Subwords::parse_word_pieces(kWords, "v", Letters::kAsWritten);
  EXPECT_THAT(pieces_of(cased, "Walk walk WALK caf\xC3\xA9"),
              ElementsAre("Walk", "walk", "[UNK]", "[UNK]"));
}

TEST(WordPieces, MakeWordsAsBertDoes) {
  const Subwords words = Subwords::parse_word_pieces(kWords, "v");
  EXPECT_THAT(pieces_of(words, "walk\xE5\xB7\xA6walk"), ElementsAre("walk", "\xE5\xB7\xA6", "walk"))
      << "a Chinese character stands alone";
  EXPECT_THAT(pieces_of(words, "wa\xC2\xADlk\x01 \xE2\x80\xA8the\xC2\xA0sofa"),
              ElementsAre("walk", "the", "sofa"))
      << "control characters go, and any blank splits";
  EXPECT_THAT(pieces_of(words, "wa\xFFlk"), ElementsAre("walk")) << "not UTF-8";
  EXPECT_THAT(pieces_of(words, "[SEP]"), ElementsAre("[UNK]", "[UNK]", "[UNK]")) << "only text";
  const std::string most = "walk" + std::string(96, 'k');
  EXPECT_THAT(pieces_of(words, most), ::testing::SizeIs(97));
  EXPECT_THAT(pieces_of(words, most + "k"), ElementsAre("[UNK]")) << "101 characters";
}

TEST(WordPieces, ListAllThatIsWrong) {
  const auto faults = [](const std::string& text) {
    return tests::refusal<InvalidInput>([&] { Subwords::parse_word_pieces(text, "vocab.txt"); });
  };
  EXPECT_EQ(faults(kWords), "accepted");
  EXPECT_EQ(faults("[PAD]\r\n[UNK]\r\n[CLS]\r\n[SEP]"), "accepted");
  EXPECT_EQ(faults("\xEF\xBB\xBF[PAD]\r\n[UNK]\r\n[CLS]\r\n[SEP]\r\n\r\n\n"), "accepted");
  EXPECT_THAT(faults("[PAD]\n\nwalk\nwalk\n\xC3\n"),
              AllOf(HasSubstr("vocab.txt: line 2: no piece"),
                    HasSubstr("line 4: \"walk\" stands on"), HasSubstr("line 5: "),
                    HasSubstr("[UNK] is not in it"), HasSubstr("[SEP] is not in it")));
  EXPECT_THROW(Subwords::load("/nowhere/vocab.txt"), FileError);
}

TEST(WordPieces, BecomeEncodingsOfAnnotations) {
  using tasks::Task;
  const Subwords words = Subwords::parse_word_pieces(kWords, "v");
  const std::string text =
      R"([{"path_id": 7, "scan": "s", "heading": 0.5, "path": ["a", "b"], "distance": 3.0,
           "instructions": ["Walk.", "the sofa"]}])";
  tasks::Annotations read = tasks::parse_annotations(text, "a.json", "train", Task::kR2r);
  encode_instructions(read, words);
  ASSERT_EQ(read.paths[0].details.size(), 2U);
  EXPECT_THAT(read.paths[0].details[1].tokens, ElementsAre(2, 11, 10, 3));
  const std::string written = tasks::to_text(read);
  EXPECT_THAT(written, HasSubstr("\"instr_encodings\""));
  EXPECT_EQ(tasks::parse_annotations(written, "a.json", "train", Task::kR2r).paths, read.paths);
  read.task = Task::kCvdn;
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { encode_instructions(read, words); }),
              HasSubstr("a.json: CVDN's token ids are those of a dialogue"));
}

// ----- SentencePiece

std::string number(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7U) bytes += static_cast<char>(value | 0x80U);
  return bytes + static_cast<char>(value);
}
std::string text_field(unsigned field, const std::string& text) {
  return number(field << 3U | 2U) + number(text.size()) + text;
}
std::string number_field(unsigned field, std::uint64_t value) {
  return number(field << 3U) + number(value);
}
std::string little_endian(std::uint32_t value) {
  std::string bytes;
  for (unsigned k = 0; k < 4; ++k) bytes += static_cast<char>(value >> 8U * k);
  return bytes;
}
std::string piece(const std::string& text, float score, unsigned type = 1) {
  const std::string bits = little_endian(std::bit_cast<std::uint32_t>(score));
  return text_field(1, text_field(1, text) + number(2U << 3U | 5U) + bits + number_field(3, type));
}

const std::string kBlank = "\xE2\x96\x81";
const std::string kSpecial = piece("<unk>", 0, 2) + piece("<s>", 0, 3) + piece("</s>", 0, 3);
// Ids from 4: the blank, a, b, ab, blank-ab; the mask is 9.
const std::string kModel = kSpecial + piece(kBlank, -2) + piece("a", -3) + piece("b", -3) +
                           piece("ab", -5) + piece(kBlank + "ab", -8);

Subwords model(const std::string& bytes) { return Subwords::parse_sentence_pieces(bytes, "m"); }

TEST(SentencePieces, AreTheMostProbableOnes) {
  const Subwords pieces = model(kModel);
  EXPECT_EQ(pieces.size(), 10U);
  EXPECT_EQ(pieces.mask(), 9U);
  EXPECT_EQ(pieces.pad(), 1U);
  EXPECT_EQ(pieces.piece(1), "<pad>");
  EXPECT_EQ(pieces.find("ab"), 7U);
  // Blank and ab have -2 - 5 = -7; as one piece -8, with two letters -2 - 3 - 3 = -8.
  EXPECT_THAT(pieces.encode("ab"), ElementsAre(0, 4, 7, 2));
  EXPECT_THAT(pieces.encode("  ab   ba "), ElementsAre(0, 4, 7, 4, 6, 5, 2));
  EXPECT_THAT(pieces.encode("axyb"), ElementsAre(0, 4, 5, 3, 6, 2)) << "one unknown for a run";
  EXPECT_THAT(pieces.encode(""), ElementsAre(0, 2));
  EXPECT_THAT(pieces.encode("\xFF"), ElementsAre(0, 4, 3, 2));
}

TEST(SentencePieces, FollowTheFilesRules) {
  const auto with = [](const std::string& rules) { return model(kModel + text_field(3, rules)); };
  EXPECT_THAT(with(number_field(3, 0)).encode("ab a"), ElementsAre(0, 7, 4, 5, 2));
  EXPECT_THAT(with(number_field(4, 0)).encode(" a "), ElementsAre(0, 4, 4, 5, 4, 2));
  const Subwords own = model(kModel + piece("xa", 0, 4));
  EXPECT_THAT(own.encode("xab"), ElementsAre(0, 4, 9, 6, 2)) << "a user's symbol is always taken";
  EXPECT_THAT(model(kModel + piece("ba", 9, 5)).encode("ba"), ElementsAre(0, 4, 6, 5, 2))
      << "an unused one never";
}

// A trie with one key, "X", whose value points at "ab": the root's offset is 0x58 ^ 0x59 = 1, so
// its child by X is unit 0x59, whose value stands at 0x59 ^ 2 = 0x5b.
std::string table(std::uint32_t value) {
  std::vector<std::uint32_t> units(0x5c, 0);
  units[0] = 1U << 10U;
  units[0x59] = 2U << 10U | 0x100U | 'X';
  units[0x5b] = 0x80000000U | value;
  std::string bytes = little_endian(static_cast<std::uint32_t>(4 * units.size()));
  for (const std::uint32_t unit : units) bytes += little_endian(unit);
  return bytes + std::string("q\0ab\0", 5);
}

TEST(SentencePieces, ReplaceCharactersByTheFilesTable) {
  const auto with = [](const std::string& rules) {
    return model(kModel + text_field(3, text_field(2, rules)));
  };
  EXPECT_THAT(with(table(2)).encode("X"), ElementsAre(0, 4, 7, 2));
  EXPECT_THAT(with(table(2)).encode("aX"), ElementsAre(0, 4, 5, 7, 2));
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { (void)with(table(5)).encode("X"); }),
              HasSubstr("precompiled_charsmap: text 5 of 5 bytes"));
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { with(table(2).substr(0, 100)); }),
              HasSubstr("precompiled_charsmap: a trie of 368 bytes in 100"));
}

TEST(SentencePieces, SayWhatIsNotXlmRs) {
  const auto fault = [](const std::string& bytes) {
    return tests::refusal<InvalidInput>([&] { model(bytes); });
  };
  EXPECT_EQ(fault(kModel), "accepted");
  EXPECT_THAT(fault(""), HasSubstr("m: $.pieces[0]: \"\", not \"<unk>\", as XLM-R's begin"));
  EXPECT_THAT(fault("some text"), HasSubstr("not a SentencePiece model that can be read"));
  EXPECT_THAT(fault(kModel.substr(0, 25)), HasSubstr("bytes wanted"));
  EXPECT_THAT(fault(kModel + piece("a", -1)), HasSubstr("$.pieces[8]: \"a\" stands in it twice"));
  EXPECT_THAT(fault(kModel + piece("<0x0A>", -1, 6)), HasSubstr("$.pieces[8]: a piece for a byte"));
  EXPECT_THAT(fault(kModel + piece("c", -1, 7)), HasSubstr("a piece of type 7, not 1 to 6"));
  EXPECT_THAT(fault(kModel + piece("c", std::numeric_limits<float>::infinity())),
              HasSubstr("score inf"));
  EXPECT_THAT(fault(kModel + text_field(2, number_field(3, 2))),
              HasSubstr("$.trainer_spec: model_type 2, not 1 (unigram)"));
  EXPECT_THAT(fault(kModel + number_field(1, 2)), HasSubstr("field 1 has wire type 0, not 2"));
}

// ----- against the public packages

// A python3 that has a package: the first on the path may be another one than Debian's.
std::optional<std::string> python_with(const std::string& package) {
  for (const std::string python : {"python3", "/usr/bin/python3"}) {
    const std::string command = python + " -c 'import " + package + "' > /dev/null 2>&1";
    if (std::system(command.c_str()) == 0) return python;
  }
  return std::nullopt;
}

nlohmann::json truth_of(const std::string& python, const std::string& what,
                        const std::filesystem::path& folder) {
  const std::string command = python + " '" EN_SOURCE_DIR "/tests/python/subwords_truth.py' '" +
                              folder.string() + "' " + what + " > /dev/null 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  return nlohmann::json::parse(read_file(folder / "truth.json"));
}

void expect_same(const Subwords& words, const nlohmann::json& truth, const std::string& key) {
  std::size_t differ = 0;
  for (std::size_t i = 0; i < truth["texts"].size(); ++i) {
    auto expected = truth[key][i].get<std::vector<std::int32_t>>();
    expected.insert(expected.begin(), static_cast<std::int32_t>(words.begin()));
    expected.push_back(static_cast<std::int32_t>(words.end()));
    if (words.encode(truth["texts"][i].get<std::string>()) == expected) continue;
    ADD_FAILURE() << key << ", text " << i << ": " << truth["texts"][i];
    if (++differ == 5) return;
  }
}

TEST(SubwordsOfPackages, WordPiecesAreTokenizers) {
  const auto python = python_with("tokenizers");
  if (!python) GTEST_SKIP() << "no tokenizers for python3: pip install tokenizers";
  const tests::TemporaryFolder folder("word_pieces");
  const nlohmann::json truth = truth_of(*python, "words", folder.path());
  expect_same(Subwords::load(folder.path() / "vocab.txt"), truth, "folded");
  expect_same(Subwords::load(folder.path() / "vocab.txt", Letters::kAsWritten), truth, "written");
}

TEST(SubwordsOfPackages, SentencePiecesAreSentencepieces) {
  const auto python = python_with("sentencepiece");
  if (!python) GTEST_SKIP() << "no sentencepiece for python3: pip install sentencepiece";
  const tests::TemporaryFolder folder("sentence_pieces");
  const nlohmann::json truth = truth_of(*python, "sentences", folder.path());
  for (const std::string key : {"plain", "own", "bare"}) {
    expect_same(Subwords::load(folder.path() / (key + ".model")), truth, key);
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::models
