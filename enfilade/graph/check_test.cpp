#include "enfilade/graph/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/scan/data_root.h"
#include "tests/support/graphs.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::graph {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> places(const scan::Connectivity& c) {
  std::vector<std::string> found;
  for (const Diagnostic& d : check_graph(c)) found.push_back(d.code + " " + d.where);
  return found;
}

TEST(CheckGraph, NothingIsOddAboutASquare) { EXPECT_TRUE(places(testing::square()).empty()); }

TEST(CheckGraph, FindsEachOddity) {
  scan::Connectivity c = testing::square();
  c.entries[0].unobstructed = {ViewpointIndex(1)};
  EXPECT_THAT(places(c), ElementsAre("one-way-edge $[3].unobstructed[0]"));

  c = testing::square();
  c.entries[2].unobstructed.insert(c.entries[2].unobstructed.begin() + 1, ViewpointIndex(2));
  EXPECT_THAT(places(c), ElementsAre("self-edge $[2].unobstructed[2]"));

  c = testing::square();
  c.entries[1].included = false;
  EXPECT_THAT(places(c), ElementsAre("edge-to-excluded $"));

  c = testing::square();
  c.entries[1].pose[0] = 2;
  EXPECT_THAT(places(c), ElementsAre("bad-pose $[1].pose"));
  c.entries[1].pose[0] = -1;  // a mirror image
  EXPECT_THAT(places(c), ElementsAre("bad-pose $[1].pose"));

  EXPECT_THAT(places(testing::connectivity("s", {{0, 0, 0}, {6, 0, 0}}, {{0, 1}})),
              ElementsAre("long-edge $[0].unobstructed[1]"));
  EXPECT_THAT(places(testing::connectivity("s", {{0, 0, 0}, {0.01, 0, 2}}, {{0, 1}})),
              ElementsAre("steep-edge $[0].unobstructed[1]"));
  EXPECT_THAT(places(testing::connectivity("s", {{0, 0, 0}, {0, 0, 0}}, {{0, 1}})),
              ElementsAre("same-position $[0].unobstructed[1]"));
  EXPECT_THAT(places(testing::connectivity("s", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1}})),
              ElementsAre("isolated-viewpoint $[2]"));
  EXPECT_THAT(
      places(testing::connectivity("s", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}},
                                   {{0, 1}, {2, 3}, {3, 4}})),
      ElementsAre("disconnected-part $[0]"));
  EXPECT_THAT(places(scan::Connectivity{}), ElementsAre("no-viewpoints $"));
}

TEST(CheckFolder, ReportsFilesThatCannotBeUsedAndGoesOn) {
  const tests::TemporaryFolder made("check_folder");
  const fs::path& folder = made.path();
  EXPECT_THROW(check_folder(folder), FileError);
  write_file_atomically(folder / "good_connectivity.json", to_json(testing::square("good")));
  EXPECT_EQ(check_folder(folder).size(), 1U) << "without scans.txt, the files that are there";
  write_file_atomically(folder / "scans.txt", "absent broken good");
  write_file_atomically(folder / "broken_connectivity.json", "[{]");
  write_file_atomically(folder / "more_connectivity.json", "[]");
  const auto reports = check_folder(folder);
  ASSERT_EQ(reports.size(), 4U);
  EXPECT_EQ(reports[0].diagnostics.at(0).code, "no-file");
  EXPECT_EQ(reports[1].diagnostics.at(0).code, "not-json");
  EXPECT_TRUE(reports[2].diagnostics.empty());
  EXPECT_EQ(reports[2].edges, 4U);
  EXPECT_EQ(reports[3].diagnostics.at(0).code, "unlisted-file");
}

TEST(CheckFolder, ReadsPackedFiles) {
  const tests::TemporaryFolder made("check_packed");
  const fs::path& folder = made.path();
  write_file_atomically(folder / "one_connectivity.json.gz", gzip(to_json(testing::square()), 6));
  write_file_atomically(folder / "two_connectivity.json", to_json(testing::square("two")));
  write_file_atomically(folder / "two_connectivity.json.gz", gzip("[]", 6));
  const auto all = check_folder(folder);
  ASSERT_EQ(all.size(), 2U) << "without scans.txt, each scan once";
  EXPECT_EQ(all[0].scan, "one");
  EXPECT_EQ(all[0].edges, 4U);
  EXPECT_EQ(all[1].edges, 4U) << "the plain one counts";
  write_file_atomically(folder / "scans.txt", "two");
  const auto listed = check_folder(folder);
  ASSERT_EQ(listed.size(), 2U);
  EXPECT_EQ(listed[1].diagnostics.at(0).code, "unlisted-file");
  EXPECT_THAT(listed[1].diagnostics.at(0).file, HasSubstr("one_connectivity.json.gz"));
}

TEST(CheckFolder, CountsTheOdditiesOfTheRealGraphs) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real graphs";
  std::map<std::string, int> counts;
  for (const FileReport& report : check_folder(data->connectivity())) {
    for (const Diagnostic& d : report.diagnostics) ++counts[d.code];
  }
  EXPECT_EQ(counts["isolated-viewpoint"], 8);
  EXPECT_EQ(counts["long-edge"], 176);
  EXPECT_EQ(counts["steep-edge"], 15);
  EXPECT_EQ(counts["one-way-edge"], 0);
  EXPECT_EQ(counts["self-edge"], 0);
}

}  // namespace EN_UNIT
}  // namespace enfilade::graph
