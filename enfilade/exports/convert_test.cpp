#include "enfilade/exports/convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/tasks/files.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::exports {
namespace EN_UNIT {

using nlohmann::json;
using tasks::Task;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Convert, KindsAreFoundByTheirFirstRecord) {
  const tests::TemporaryFolder folder("convert");
  const auto kind = [&](const std::string& name, const std::string& text) {
    write_file_atomically(folder.path() / name, text);
    return find_kind(folder.path() / name);
  };
  EXPECT_EQ(kind("a.json", R"([{"path_id": 1, "path": ["v"]}])"), FileKind::kAnnotations);
  EXPECT_EQ(kind("a.jsonl", "{\"path_id\": 1, \"path\": [\"v\"]}\n"), FileKind::kAnnotations);
  EXPECT_EQ(kind("r.json", R"([{"instr_id": "1_0", "trajectory": []}])"), FileKind::kResults);
  EXPECT_EQ(kind("r.json", R"([{"inst_idx": 1, "trajectory": []}])"), FileKind::kResults);
  EXPECT_EQ(kind("f.jsonl", R"({"demonstration_id": 1, "path": []})"), FileKind::kFollowers);
  EXPECT_EQ(kind("b.json", R"({"s_v": {"1": {"name": "a"}}})"), FileKind::kBoxes);
  EXPECT_EQ(kind("b.json", " {}\n"), FileKind::kBoxes);
  EXPECT_EQ(kind("f.hdf5", ""), FileKind::kFeatures);
  EXPECT_EQ(find_kind(folder.path()), FileKind::kBoxes);
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { kind("x.json", "[1]"); }), HasSubstr("records"));
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { kind("x.json", "[]"); }), HasSubstr("records"));
}

TEST(Convert, KeysOfResultsChangeAndNothingElse) {
  const std::string official =
      R"([{"instr_id": "1_2_0", "trajectory": [["v", 0.1, 0]], "predObjId": 66, "more": null}])";
  const std::string duet = with_keys(official, "r.json", ResultKeys::kDuet, Task::kReverie);
  EXPECT_EQ(json::parse(duet), json::parse(R"([{"instr_id": "1_2_0", "trajectory": [["v", 0.1, 0]],
                             "pred_objid": 66, "more": null}])"));
  EXPECT_EQ(json::parse(with_keys(duet, "r.json", ResultKeys::kOfficial, Task::kReverie)),
            json::parse(official));
  const std::string number = R"([{"inst_idx": 12, "trajectory": ["v"]}])";
  const std::string text = with_keys(number, "r.json", ResultKeys::kDuet, Task::kCvdn);
  EXPECT_EQ(json::parse(text), json::parse(R"([{"instr_id": "12", "trajectory": ["v"]}])"));
  EXPECT_EQ(json::parse(with_keys(text, "r.json", ResultKeys::kOfficial, Task::kCvdn)),
            json::parse(number));
}

TEST(Convert, FaultsOfResultsHaveTheirPlaces) {
  EXPECT_THAT(tests::refusal<InvalidInput>([] {
                with_keys(R"([{"predObjId": 1, "pred_objid": 1}, 7])", "r.json", ResultKeys::kDuet,
                          Task::kReverie);
              }),
              AllOf(HasSubstr("$[0]: both predObjId and pred_objid"), HasSubstr("$[1]")));
  EXPECT_THAT(tests::refusal<InvalidInput>([] {
                with_keys(R"([{"instr_id": "1_0"}])", "r.json", ResultKeys::kOfficial, Task::kCvdn);
              }),
              HasSubstr("$[0].instr_id"));
  EXPECT_THAT(tests::refusal<InvalidInput>(
                  [] { with_keys("{}", "r.json", ResultKeys::kDuet, Task::kCvdn); }),
              HasSubstr("not a list"));
  EXPECT_THAT(tests::refusal<InvalidInput>(
                  [] { with_keys("[", "r.json", ResultKeys::kDuet, Task::kCvdn); }),
              HasSubstr("not-json"));
  EXPECT_THAT(tests::refusal<InvalidInput>([] {
                with_keys(R"([{"inst_idx": 1, "inst_idx": 2}])", "r.json", ResultKeys::kDuet,
                          Task::kCvdn);
              }),
              HasSubstr("\"inst_idx\": given twice in one object"));
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  EXPECT_THAT(tests::refusal<InvalidInput>(
                  [&] { with_keys(deep, "r.json", ResultKeys::kDuet, Task::kCvdn); }),
              HasSubstr("more than 64 levels"));
}

TEST(Convert, AnnotationsBecomeLinesAndAList) {
  const std::string list =
      R"([{"path_id": 1, "scan": "s", "heading": 0.5, "path": ["a", "b"], "distance": 3.0,
           "instructions": ["go", "walk", "move"]}])";
  const tasks::Annotations read = tasks::parse_annotations(list, "a.json", "train", Task::kR2r);
  const std::string lines = annotations_text(read, {.lines = true});
  EXPECT_TRUE(lines.starts_with("{\"path_id\"") || lines.starts_with("{\"")) << lines;
  EXPECT_EQ(tasks::parse_annotations(lines, "a.jsonl", "train", Task::kR2r).paths, read.paths);
  const std::string again = annotations_text(read, {});
  EXPECT_EQ(tasks::parse_annotations(again, "a.json", "train", Task::kR2r).paths, read.paths);
}

TEST(Convert, SoonsEntriesBecomeLinesWithoutWhatTiesThem) {
  const auto corner = [](const char* name) {
    return "\"" + std::string(name) + R"(": {"heading": 0.5, "elevation": -0.25})";
  };
  std::string target = corner("center");
  for (const char* name : {"left_top", "right_top", "right_bottom", "left_bottom"}) {
    target += ", " + corner(name);
  }
  const std::string released =
      R"([{"instr_id": "x", "path": [["a", "c"], ["a", "b", "c"]], "instructions": [["n", "a", "r", "g", "t"]], )"
      R"("bboxes": [{"scan": "s", "image_id": "c", "obj_name": "vase", "target": {)" +
      target + "}}]}]";
  const tasks::Annotations read =
      tasks::parse_annotations(released, "train.json", "train", Task::kSoon);
  ASSERT_EQ(read.paths.size(), 2U);
  const std::string lines = annotations_text(read, {});
  const tasks::Annotations again =
      tasks::parse_annotations(lines, "train.jsonl", "train", Task::kSoon);
  ASSERT_EQ(again.paths.size(), 2U);
  EXPECT_EQ(again.paths[1].path, read.paths[1].path);
  EXPECT_FALSE(again.paths[1].group.has_value());
  EXPECT_EQ(tasks::parse_annotations(annotations_text(read, {.released = true}), "train.json",
                                     "train", Task::kSoon)
                .paths,
            read.paths);
}

}  // namespace EN_UNIT
}  // namespace enfilade::exports
