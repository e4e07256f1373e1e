#include "enfilade/tasks/formats/readers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "enfilade/core/gzip.h"
#include "enfilade/scan/data_root.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks::formats {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

// Three instructions; the last has no pieces, as one of the real ones.
constexpr const char* kEntry = R"([{
  "distance": 7.25, "scan": "vyrNrziPKCB", "path_id": 55, "path": ["v0", "v1", "v2"],
  "heading": 0.053, "instructions": ["Go on, stop. ", "It's there. ", "Wait. "],
  "new_instructions": "[[['go', 'on'], ['stop']], [[\"it's\", 'there']]]",
  "chunk_view": [[[1, 3], [3, 3]], [[1, 3]]]}])";

std::string edited(const std::string& from, const std::string& to, std::string text = kEntry) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string faults_of(const std::string& text) {
  return tests::refusal<InvalidInput>([&] { parse_fine_grained(text, "f.json", "val"); });
}

TEST(FineGrained, GivesPiecesOfInstructionsWithTheirPlaces) {
  const Annotations read = parse_fine_grained(kEntry, "f.json", "val");
  EXPECT_EQ(read.split, "val");
  EXPECT_EQ(read.file, "f.json");
  EXPECT_EQ(read.task, Task::kR2r);
  ASSERT_EQ(read.paths.size(), 1U);
  const PathAnnotation& path = read.paths[0];
  EXPECT_EQ(path.path_id, 55);
  EXPECT_EQ(path.scan, "vyrNrziPKCB");
  EXPECT_EQ(path.heading, Radians(0.053));
  EXPECT_EQ(path.distance, 7.25);
  EXPECT_THAT(path.path, ElementsAre("v0", "v1", "v2"));
  EXPECT_THAT(path.instructions, ElementsAre("Go on, stop. ", "It's there. ", "Wait. "));
  ASSERT_EQ(path.details.size(), 3U);
  ASSERT_EQ(path.details[0].parts.size(), 2U);
  EXPECT_THAT(path.details[0].parts[0].words, ElementsAre("go", "on"));
  EXPECT_THAT(path.details[0].parts[0].places, ::testing::Optional(Pair(0U, 2U)));
  EXPECT_THAT(path.details[0].parts[1].words, ElementsAre("stop"));
  EXPECT_THAT(path.details[0].parts[1].places, ::testing::Optional(Pair(2U, 2U)));
  ASSERT_EQ(path.details[1].parts.size(), 1U);
  EXPECT_THAT(path.details[1].parts[0].words, ElementsAre("it's", "there"));
  EXPECT_THAT(path.details[2].parts, IsEmpty());
}

TEST(FineGrained, HasNoPlacesInTestSplits) {
  const Annotations read = parse_fine_grained(
      edited(",\n  \"chunk_view\": [[[1, 3], [3, 3]], [[1, 3]]]", ""), "f.json", "test");
  EXPECT_EQ(read.paths[0].details[0].parts[1].words, std::vector<std::string>{"stop"});
  EXPECT_EQ(read.paths[0].details[0].parts[1].places, std::nullopt);
  EXPECT_EQ(parse_fine_grained(to_r2r_family(read), "f.json", "test").paths, read.paths);
}

TEST(FineGrained, IsReadBackEqual) {
  const std::string first_without =
      edited("[[[1, 3]", "[[], [[1, 3]", edited("[[['go'", "[[], [['go'"));
  for (const std::string& text :
       {std::string(kEntry), first_without,
        edited("\"heading\"", "\"instr_encodings\": [[101, 102], [], [7]], \"heading\"")}) {
    const Annotations read = parse_fine_grained(text, "f.json", "val");
    EXPECT_EQ(parse_fine_grained(to_r2r_family(read), "f.json", "val").paths, read.paths) << text;
  }
}

TEST(FineGrained, RefusesToWriteHalfOfThePlaces) {
  Annotations read = parse_fine_grained(kEntry, "f.json", "val");
  read.paths[0].details[1].parts[0].places.reset();
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { to_r2r_family(read); }),
              HasSubstr("path 55: 2 of 3 parts of instructions have places; all or none"));
}

TEST(FineGrained, NamesFieldPlaceAndWhatIsAllowed) {
  const std::string literal = R"("[[['go', 'on'], ['stop']], [[\"it's\", 'there']]]")";
  const struct {
    const char* name;
    std::string text;
    std::string fault;
  } rows[]{
      {"empty file", "", "f.json: $: the file is empty"},
      {"no entry", "[7]", "f.json: $[0]: number 7, not an object"},
      {"NaN", edited("0.053", "NaN"), "NaN and Infinity are not JSON"},
      {"no literal", edited("new_instructions", "old"), "$[0]: has no field \"new_instructions\""},
      {"literal given twice",
       edited("\"chunk_view\"", "\"new_instructions\": \"[]\", \"chunk_view\""),
       "$[0].new_instructions: given twice"},
      {"a list instead of a text", edited(literal, "[[[\"go\"]]]"),
       "$[0].new_instructions: array of 1, not a string"},
      {"cut literal", edited("'there']]]", "'there'"),
       "$[0].new_instructions: byte 44: the text ends; , or ] is expected"},
      {"words of a list of lists", edited(literal, R"("[['go', 'on']]")"),
       "$[0].new_instructions: byte 2: \"'go', 'on']]\"; the list of a piece or ] is expected"},
      {"more lists than instructions",
       edited("[\"Go on, stop. \", \"It's there. \", \"Wait. \"]", "[\"Go. \"]"),
       "$[0].new_instructions: lists of 2 instructions; the path has 1"},
      {"more pieces than chunks", edited("[3, 3]], ", "[3, 3]], [[1, 2]], "),
       "$[0].chunk_view: array of 3; 2 are expected, one for each instruction"},
      {"fewer chunks than pieces", edited(", [3, 3]]", "]"),
       "$[0].chunk_view[0]: array of 1; 2 are expected, one for each piece"},
      {"chunks that are no list", edited("[[[1, 3], [3, 3]], [[1, 3]]]", "{}"),
       "$[0].chunk_view: object, not an array"},
      {"a chunk that is no list", edited("[3, 3]", "3"),
       "$[0].chunk_view[0][1]: number 3, not an array"},
      {"a chunk of three", edited("[3, 3]", "[1, 2, 3]"),
       "$[0].chunk_view[0][1]: array of 3, not [first, last]"},
      {"a place that is no number", edited("[3, 3]", "[\"3\", 3]"),
       "$[0].chunk_view[0][1][0]: string \"3\", not a whole number"},
      {"a place between", edited("[3, 3]", "[2.5, 3]"),
       "$[0].chunk_view[0][1][0]: number 2.5, not a whole number"},
      {"place 0", edited("[3, 3]", "[0, 3]"), "$[0].chunk_view[0][1]: [0, 3] are no places"},
      {"a negative place", edited("[3, 3]", "[-1, 3]"),
       "$[0].chunk_view[0][1]: [-1, 3] are no places"},
      {"beyond the path", edited("[3, 3]", "[3, 4]"),
       "$[0].chunk_view[0][1]: [3, 4] are no places on a path of 3; 1 to 3 are"},
      {"a huge place", edited("[3, 3]", "[3, 9223372036854775807]"),
       "are no places on a path of 3"},
      {"backwards", edited("[3, 3]", "[3, 2]"),
       "[3, 2] are no places on a path of 3; 1 to 3 are, the first not after"},
      {"tokens of fewer instructions",
       edited("\"heading\"", "\"instr_encodings\": [[1]], \"heading\""),
       "$[0].instr_encodings: 1 lists of tokens; 3 are expected"},
  };
  for (const auto& row : rows) EXPECT_THAT(faults_of(row.text), HasSubstr(row.fault)) << row.name;
}

TEST(FineGrained, ListsAllFaultsAtOnce) {
  std::string text = edited("[3, 3]", "[3, 4]");
  text.replace(text.find("\"vyrNrziPKCB\""), 13, "5");
  text.insert(text.rfind(']'), ", {\"path_id\": 55}, 9");
  EXPECT_THAT(faults_of(text), AllOf(HasSubstr("$[0].scan: number 5, not a string"),
                                     HasSubstr("$[1]: has no field \"scan\""),
                                     HasSubstr("$[1]: has no field \"new_instructions\""),
                                     HasSubstr("$[2]: number 9")));
}

struct Counts {
  std::size_t items = 0, instructions = 0, parts = 0, words = 0, still = 0;
  friend bool operator==(const Counts&, const Counts&) = default;
};

Counts counts_of(const Annotations& annotations) {
  Counts counts;
  counts.items = annotations.paths.size();
  for (const PathAnnotation& path : annotations.paths) {
    counts.instructions += path.instructions.size();
    for (const InstructionDetails& details : path.details) {
      counts.parts += details.parts.size();
      for (const SubInstruction& part : details.parts) {
        counts.words += part.words.size();
        counts.still += part.places.value().first == part.places.value().second ? 1 : 0;
      }
    }
  }
  return counts;
}

TEST(FineGrained, OfRealSplits) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real annotations";
  const struct {
    const char* split;
    Counts counts;
  } splits[]{{"val_seen", {340, 1021, 3775, 27083, 607}},
             {"val_unseen", {783, 2349, 8481, 61501, 1188}}};
  for (const auto& [split, counts] : splits) {
    const auto file = data->folder() / "fgr2r" / ("FGR2R_" + std::string(split) + ".json");
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    const Annotations read = parse_fine_grained(read_text_file(file), file.string(), split);
    EXPECT_EQ(counts_of(read), counts) << split;
    EXPECT_EQ(parse_fine_grained(to_r2r_family(read), "", split).paths, read.paths) << split;
    // But for the pieces they are R2R's own.
    const Annotations plain = load_annotations(data->annotations(split), split);
    ASSERT_EQ(plain.paths.size(), read.paths.size());
    for (std::size_t i = 0; i < plain.paths.size(); ++i) {
      PathAnnotation path = read.paths[i];
      path.details.clear();
      EXPECT_EQ(path, plain.paths[i]) << split << ' ' << i;
      EXPECT_EQ(read.paths[i].details[0].parts.front().places.value().first, 0U);
      EXPECT_EQ(read.paths[i].details[0].parts.back().places.value().second, path.path.size() - 1);
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks::formats
