#include "enfilade/graph/corrections.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/graph/nav_graph.h"
#include "tests/support/graphs.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::graph {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Action = Correction::Action;

constexpr const char* kFile = R"({"scan": "square", "corrections": [
  {"action": "add-edge", "from": "v0", "to": "v2", "who": "Ada", "why": "glass, not a wall",
   "when": "2026-05-01"},
  {"action": "remove-edge", "from": "v1", "to": "v0", "who": "Ada", "why": "a rope hangs there"},
  {"action": "exclude", "from": "v3", "who": "Ben", "why": "stands in a cupboard"}]})";

// What is wrong with a file of one correction: "where code: message" of the first fault.
std::string fault(const std::string& correction, const std::string& scan = "\"square\"") {
  try {
    parse_corrections("{\"scan\":" + scan + ",\"corrections\":[" + correction + "]}", "c.json");
  } catch (const InvalidInput& e) {
    const Diagnostic& d = e.diagnostics().front();
    return d.where + " " + d.code + ": " + d.message;
  }
  return "";
}

TEST(Corrections, ReadsAll) {
  const Corrections c = parse_corrections(kFile, "c.json");
  EXPECT_EQ(c.scan, "square");
  ASSERT_EQ(c.list.size(), 3U);
  EXPECT_EQ(c.list[0].action, Action::kAddEdge);
  EXPECT_EQ(c.list[0].from, "v0");
  EXPECT_EQ(c.list[0].to, "v2");
  EXPECT_EQ(c.list[0].who, "Ada");
  EXPECT_EQ(c.list[0].why, "glass, not a wall");
  EXPECT_EQ(c.list[0].when, "2026-05-01");
  EXPECT_EQ(c.list[1].action, Action::kRemoveEdge);
  EXPECT_EQ(c.list[2].action, Action::kExclude);
  EXPECT_EQ(c.list[2].to, "");
}

TEST(Corrections, AMisspelledFieldIsRefused) {
  EXPECT_EQ(fault(R"({"action": "exclude", "from": "v0", "who": "A", "why": "B", "wen": "C"})"),
            "$.corrections[0] unknown-field: unknown field \"wen\"; the nearest is \"when\"");
}

TEST(Corrections, WhatIsWrittenReadsBack) {
  const Corrections c = parse_corrections(kFile, "c.json");
  const std::string text = to_json(c);
  EXPECT_EQ(to_json(parse_corrections(text, "again")), text);
  EXPECT_THAT(text, HasSubstr("\"exclude\""));
}

TEST(Corrections, LoadsFilesAndNamesThoseThatAreNotThere) {
  const tests::TemporaryFolder folder("corrections");
  write_file_atomically(folder.path() / "c.json", kFile);
  EXPECT_EQ(load_corrections(folder.path() / "c.json").list.size(), 3U);
  write_file_atomically(folder.path() / "packed.json.gz", gzip(kFile, 6));
  EXPECT_EQ(load_corrections(folder.path() / "packed.json").list.size(), 3U);
  EXPECT_THROW(load_corrections(folder.path() / "none.json"), FileError);
}

TEST(Corrections, RefusesWhatIsBroken) {
  const std::string whole = R"({"action":"add-edge","from":"a","to":"b","who":"me","why":"seen"})";
  EXPECT_EQ(fault(whole), "");
  EXPECT_THAT(fault("7"), HasSubstr("$.corrections[0]"));
  EXPECT_THAT(fault("{}"), HasSubstr("missing-field"));
  EXPECT_THAT(fault(whole, "5"), HasSubstr("$.scan"));
  EXPECT_THAT(fault(whole, "\"\""), HasSubstr("$.scan bad-id"));
  EXPECT_THAT(fault(R"({"action":"move","from":"a","who":"me","why":"x"})"),
              HasSubstr("$.corrections[0].action bad-action: string \"move\", not add-edge"));
  EXPECT_THAT(fault(R"({"action":"add-edge","from":"a","to":"b","who":"","why":"x"})"),
              HasSubstr("$.corrections[0].who empty-field"));
  EXPECT_THAT(fault(R"({"action":"add-edge","from":"a","to":"b","who":"me"})"),
              HasSubstr("\"why\""));
  EXPECT_THAT(fault(R"({"action":"add-edge","from":"a","who":"me","why":"x"})"),
              HasSubstr("add-edge needs \"to\""));
  EXPECT_THAT(fault(R"({"action":"exclude","from":"a","to":"b","who":"me","why":"x"})"),
              HasSubstr("unused-field"));
  EXPECT_THAT(fault(R"({"action":"add-edge","from":"a","to":"a","who":"me","why":"x"})"),
              HasSubstr("self-edge"));
  EXPECT_THROW(parse_corrections("[", "c.json"), InvalidInput);
  EXPECT_THROW(parse_corrections("[]", "c.json"), InvalidInput);
}

TEST(ApplyCorrections, ChangesBothDirectionsInOrder) {
  const scan::Connectivity before = testing::square();
  const Corrected after = apply(before, parse_corrections(kFile, "c.json"), "c.json");
  EXPECT_THAT(after.notes, IsEmpty());
  const NavGraph graph(after.connectivity);
  const auto v = [](std::size_t i) { return ViewpointIndex(i); };
  EXPECT_TRUE(graph.edge(v(0), v(2)));
  EXPECT_TRUE(graph.edge(v(2), v(0)));
  EXPECT_FALSE(graph.edge(v(0), v(1)));
  EXPECT_FALSE(graph.edge(v(1), v(0)));
  EXPECT_FALSE(graph.included(v(3)));
  EXPECT_THAT(after.connectivity.entries[0].unobstructed, ElementsAre(v(2), v(3)));
  // The graph as it was traced stays as it is.
  EXPECT_THAT(before.entries[0].unobstructed, ElementsAre(v(1), v(3)));
}

TEST(ApplyCorrections, NotesWhatChangesNothing) {
  Corrections c{"square", {}};
  c.list.push_back({Action::kAddEdge, "v0", "v1", "me", "x", ""});     // is there
  c.list.push_back({Action::kRemoveEdge, "v0", "v2", "me", "x", ""});  // is not there
  c.list.push_back({Action::kInclude, "v0", "", "me", "x", ""});
  c.list.push_back({Action::kExclude, "v0", "", "me", "x", ""});
  c.list.push_back({Action::kExclude, "v0", "", "me", "x", ""});  // the second time
  const Corrected after = apply(testing::square(), c, "c.json");
  ASSERT_EQ(after.notes.size(), 4U);
  for (const Diagnostic& d : after.notes) {
    EXPECT_EQ(d.severity, Severity::kWarning);
    EXPECT_EQ(d.code, "no-change");
  }
  EXPECT_EQ(after.notes[3].where, "$.corrections[4]");
  EXPECT_FALSE(after.connectivity.entries[0].included);
}

TEST(ApplyCorrections, MakesOneWayEdgesWhole) {
  scan::Connectivity one_way = testing::square();
  one_way.entries[0].unobstructed = {ViewpointIndex(std::size_t{3})};
  Corrections c{"square", {{Action::kAddEdge, "v0", "v1", "me", "x", ""}}};
  const Corrected after = apply(one_way, c, "c.json");
  EXPECT_THAT(after.notes, IsEmpty());
  EXPECT_EQ(after.connectivity.entries[0].unobstructed.size(), 2U);
  EXPECT_EQ(after.connectivity.entries[1].unobstructed.size(), 2U);
}

TEST(ApplyCorrections, RefusesOtherScansAndUnknownIdsAllAtOnce) {
  Corrections c{"circle", {}};
  c.list.push_back({Action::kAddEdge, "v0", "w1", "me", "x", ""});
  c.list.push_back({Action::kExclude, "w2", "", "me", "x", ""});
  try {
    apply(testing::square(), c, "c.json");
    FAIL() << "was applied";
  } catch (const InvalidInput& e) {
    ASSERT_EQ(e.diagnostics().size(), 3U);
    EXPECT_EQ(e.diagnostics()[0].code, "other-scan");
    EXPECT_EQ(e.diagnostics()[1].where, "$.corrections[0].to");
    EXPECT_EQ(e.diagnostics()[2].where, "$.corrections[1].from");
    EXPECT_EQ(e.diagnostics()[2].code, "unknown-viewpoint");
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::graph
