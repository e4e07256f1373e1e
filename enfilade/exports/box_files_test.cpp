#include "enfilade/exports/box_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/objects.h"
#include "tests/support/graphs.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::exports {
namespace EN_UNIT {

using ::testing::HasSubstr;

std::shared_ptr<const graph::GraphSet> square() {
  scan::Connectivity c = graph::testing::square("s");
  c.entries[3].included = false;
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(c);
  return graph::GraphSet::of(std::move(graphs));
}

tasks::ObjectBoxes pot() {
  tasks::ObjectBoxes boxes;
  boxes.add("s", "v0", {{97, "plant#pot", {0, 12}, {{494, 146, 146, 142}, {287, 124, 115, 114}}}});
  boxes.add("s", "v3", {});
  boxes.add("other", "v0", {});
  return boxes;
}

TEST(BoxFiles, HaveTheViewpointsOfTheGraphs) {
  const tasks::ObjectBoxes chosen = boxes_of_graphs(pot(), *square());
  EXPECT_EQ(chosen.count().viewpoints, 3U) << "v3 is excluded, v1 and v2 have no objects";
  EXPECT_EQ(chosen.count().objects, 1U);
  EXPECT_FALSE(chosen.has("other", "v0"));
}

TEST(BoxFiles, AFolderIsReadBack) {
  const tests::TemporaryFolder folder("box_files");
  const auto graphs = square();
  const tasks::ObjectBoxes boxes = boxes_of_graphs(pot(), *graphs);
  write_box_folder(boxes, folder.path() / "BBox");
  EXPECT_EQ(read_file(folder.path() / "BBox" / "s_v1.json"), "{\"v1\":{}}\n");
  EXPECT_THAT(read_file(folder.path() / "BBox" / "s_v0.json"), HasSubstr("{\"v0\":{\"97\":{"));
  EXPECT_EQ(tasks::ObjectBoxes::load(folder.path() / "BBox").to_json(true), boxes.to_json(true));
}

TEST(BoxFiles, HaveNoNamesThatLeaveTheFolder) {
  tasks::ObjectBoxes boxes;
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { boxes.add("../s", "v0", {}); }),
              HasSubstr("\"../s\" is not an id"));
}

TEST(BoxFiles, ReplaceALinkInsteadOfItsTarget) {
  const tests::TemporaryFolder folder("box_files");
  const std::filesystem::path outside = folder.path() / "outside", out = folder.path() / "out";
  write_file_atomically(outside, "kept");
  std::filesystem::create_directory(out);
  std::filesystem::create_symlink(outside, out / "s_v1.json");
  write_box_folder(boxes_of_graphs(pot(), *square()), out);
  EXPECT_EQ(read_file(outside), "kept");
  EXPECT_EQ(read_file(out / "s_v1.json"), "{\"v1\":{}}\n");
}

TEST(BoxFiles, NameThePlacesOfAMeshThatIsNotThere) {
  const tests::TemporaryFolder folder("box_files");
  EXPECT_THAT(tests::refusal<LookupError>(
                  [&] { boxes_of_meshes(*square(), folder.path(), folder.path()); }),
              ::testing::AllOf(HasSubstr("no labelled mesh of scan s"),
                               HasSubstr("s/house_segmentations/s.house")));
}

TEST(BoxFiles, APackedHouseIsFound) {
  const tests::TemporaryFolder folder("box_files");
  write_file_atomically(folder.path() / "s.house.gz", gzip("no house", 6));
  EXPECT_THAT(tests::refusal<InvalidInput>(
                  [&] { boxes_of_meshes(*square(), folder.path(), folder.path()); }),
              HasSubstr("s.house.gz: line 1: \"no house\", not \"ASCII 1.0\""));
}

}  // namespace EN_UNIT
}  // namespace enfilade::exports
