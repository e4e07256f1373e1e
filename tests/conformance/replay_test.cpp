// A trace of a square room, worked out by hand, and what happens to traces that are wrong.
#include "tests/conformance/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <zlib.h>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/file.h"
#include "tests/conformance/trace.h"
#include "tests/support/graphs.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

using ::testing::HasSubstr;

constexpr const char* kHeader =
    R"({"header": 1, "configs": {"plain": {"width": 640, "height": 480, "vfov": 1.0},)"
    R"( "all": {"restricted": false}}, "defaults": {"discretized": false}})";
// Corners (0,0) (2,0) (2,2) (0,2); at v0, looking north: v3 ahead, v1 90 degrees to the right.
constexpr const char* kStart =
    R"({"s":"square","c":"plain","e":0,"a":{"new":["v0",0.0,0.0]},"st":{"scanId":"square",)"
    R"("step":0,"viewpointId":"v0","ix":0,"x":0.0,"y":0.0,"z":1.5,"heading":0.0,"elevation":0.0,)"
    R"("viewIndex":0,"nav":[["v0",0,0.0,0.0,0.0],["v3",3,0.0,0.0,2.0]]}})";
constexpr const char* kMove =
    R"({"s":"square","c":"plain","e":0,"a":{"act":[1,0.25,0.5]},"st":{"scanId":"square",)"
    R"("step":1,"viewpointId":"v3","ix":3,"x":0.0,"y":2.0,"z":1.5,"heading":0.25,"elevation":0.5,)"
    R"("viewIndex":0,"nav":[["v3",3,0.0,0.0,0.0]]}})";

std::string lines(const std::vector<std::string>& all) {
  std::string text;
  for (const std::string& line : all) text += line + "\n";
  return text;
}

std::string changed(std::string line, const std::string& from, const std::string& to) {
  const std::size_t at = line.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return line.replace(at, from.size(), to);
}

class Traces : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& content) {
    write_file_atomically(folder_ / "trace.jsonl", content);
    return folder_ / "trace.jsonl";
  }

  std::vector<Comparison> replay(const std::string& content) {
    TraceReader reader(write(content));
    Replay replay(graphs_, reader.header(), 1e-6);
    std::vector<Comparison> all;
    while (const auto step = reader.next()) all.push_back(replay.compare(*step));
    return all;
  }

  // The only mismatch of the only state.
  Mismatch mismatch(const std::string& start) {
    const auto all = replay(lines({kHeader, start}));
    if (all.size() != 1 || all[0].mismatches.size() != 1) return {"none, or several", "", ""};
    EXPECT_FALSE(all[0].identical);
    return all[0].mismatches[0];
  }

  std::string fault(const std::string& content) {
    try {
      replay(content);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

 private:
  static std::shared_ptr<const graph::GraphSet> square() {
    std::vector<graph::NavGraph> graphs;
    graphs.emplace_back(graph::testing::square());
    return graph::GraphSet::of(std::move(graphs));
  }

  const tests::TemporaryFolder made_{"traces"};
  const std::filesystem::path& folder_ = made_.path();
  std::shared_ptr<const graph::GraphSet> graphs_ = square();
};

TEST_F(Traces, ARightOneMatches) {
  const auto all = replay(lines({kHeader, kStart, "", kMove}));
  ASSERT_EQ(all.size(), 2U);
  EXPECT_TRUE(all[0].mismatches.empty());
  EXPECT_TRUE(all[1].mismatches.empty());
  // The cosine of a rounded pi/2 is 6e-17, not the 0 that stands there.
  EXPECT_FALSE(all[0].identical);
  EXPECT_TRUE(all[1].identical);
}

TEST_F(Traces, EveryFieldIsCompared) {
  const Mismatch heading = mismatch(changed(kStart, R"("heading":0.0)", R"("heading":0.00001)"));
  EXPECT_EQ(heading.field, "heading");
  EXPECT_EQ(heading.expected, "1.0000000000000001e-05");
  EXPECT_EQ(heading.got, "0");
  const std::vector<std::pair<std::string, std::string>> changes{
      {R"("scanId":"square")", R"("scanId":"round")"},
      {R"("step":0)", R"("step":1)"},
      {R"("viewpointId":"v0")", R"("viewpointId":"v1")"},
      {R"("ix":0)", R"("ix":1)"},
      {R"("x":0.0)", R"("x":0.1)"},
      {R"("y":0.0)", R"("y":0.1)"},
      {R"("z":1.5)", R"("z":1.4)"},
      {R"("elevation":0.0)", R"("elevation":0.1)"},
      {R"("viewIndex":0)", R"("viewIndex":1)"}};
  for (const auto& [from, to] : changes) {
    EXPECT_EQ(mismatch(changed(kStart, from, to)).field, from.substr(1, from.find('"', 1) - 1));
  }
  const std::string row = R"(["v3",3,0.0,0.0,2.0])";
  EXPECT_EQ(mismatch(changed(kStart, row, R"(["v2",3,0.0,0.0,2.0])")).field, "nav[1].viewpointId");
  EXPECT_EQ(mismatch(changed(kStart, row, R"(["v3",2,0.0,0.0,2.0])")).field, "nav[1].ix");
  EXPECT_EQ(mismatch(changed(kStart, row, R"(["v3",3,0.1,0.0,2.0])")).field, "nav[1].rel_heading");
  EXPECT_EQ(mismatch(changed(kStart, row, R"(["v3",3,0.0,0.1,2.0])")).field,
            "nav[1].rel_elevation");
  EXPECT_EQ(mismatch(changed(kStart, row, R"(["v3",3,0.0,0.0,2.1])")).field, "nav[1].rel_distance");
  EXPECT_EQ(mismatch(changed(kStart, "," + row, "")).field, "nav.length");
}

TEST_F(Traces, ARefusedActionIsAMismatch) {
  const auto all = replay(lines({kHeader, kStart, changed(kMove, "[1,", "[2,")}));
  ASSERT_EQ(all.size(), 2U);
  ASSERT_EQ(all[1].mismatches.size(), 1U);
  EXPECT_EQ(all[1].mismatches[0].field, "action");
  EXPECT_THAT(all[1].mismatches[0].got, HasSubstr("index 2 of its navigable list: 0 to 1"));
}

TEST_F(Traces, BrokenOnesAreNamedByFileLineAndPath) {
  EXPECT_THAT(fault(""), HasSubstr("a header line is expected"));
  EXPECT_THAT(fault("{\n"), HasSubstr("trace.jsonl:1: "));
  EXPECT_THAT(fault("{}\n"), HasSubstr("has no field \"configs\""));
  EXPECT_THAT(fault(lines({kHeader, kStart, "{\"s\":"})), HasSubstr("trace.jsonl:3: $.s"));
  EXPECT_THAT(fault(lines({kHeader, changed(kStart, "0.0,0.0]}", "0.0]}")})),
              HasSubstr("trace.jsonl:2: $.a.new: array of 2, not of 3"));
  EXPECT_THAT(fault(lines({kHeader, changed(kMove, "[1,", "[-1,")})),
              HasSubstr("$.a.act[0]: index -1"));
  EXPECT_THAT(fault(lines({kHeader, changed(kStart, "\"ix\":0", "\"ix\":0.5")})),
              HasSubstr("$.st.ix: number 0.5, not a whole number"));
  EXPECT_THAT(fault(lines({kHeader, changed(kStart, "plain", "fancy")})),
              HasSubstr("\"fancy\" is not one of the header's configs"));
  EXPECT_THAT(fault(lines({changed(kHeader, "\"vfov\": 1.0", "\"vfov\": 4")})),
              HasSubstr("$.configs.plain: camera vertical field of view 4"));
  EXPECT_THAT(fault(lines({changed(kHeader, "vfov", "zoom")})),
              HasSubstr("$.configs.plain.zoom: not one of width"));
  EXPECT_THAT(fault(lines({kHeader, changed(kStart, "\"v0\"", "\"v9\"")})),
              HasSubstr("viewpoint \"v9\" is not one of the 4"));
}

TEST_F(Traces, CompressedOnesAreReadAndCutOnesRefused) {
  const auto path = write("");
  const std::string text = lines({kHeader, kStart, kMove});
  const gzFile out = gzopen(path.c_str(), "wb");
  ASSERT_EQ(gzwrite(out, text.data(), static_cast<unsigned>(text.size())),
            static_cast<int>(text.size()));
  ASSERT_EQ(gzclose(out), Z_OK);
  const std::string whole = read_file(path);
  EXPECT_LT(whole.size(), text.size());
  EXPECT_EQ(replay(whole).size(), 2U);
  EXPECT_THAT(fault(whole.substr(0, whole.size() - 20)), HasSubstr("the file ends too early"));
  EXPECT_THROW(TraceReader("/nowhere.jsonl"), FileError);
  EXPECT_THROW(TraceReader(path.parent_path()), FileError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
