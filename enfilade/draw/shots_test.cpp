#include "enfilade/draw/contact_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/panoramas.h"

namespace enfilade::draw {
namespace EN_UNIT {

using ::testing::ElementsAre;

std::vector<std::string> captions(const std::vector<Shot>& shots) {
  std::vector<std::string> all;
  for (const Shot& shot : shots) all.push_back(shot.caption);
  return all;
}

graph::NavGraph row() {
  return graph::NavGraph(scan::testing::row_of_viewpoints("row", 3));  // 1 m apart along +x
}

TEST(Shots, OfAScanGoAroundEachViewpoint) {
  const auto source = scan::testing::memory_panoramas("row", 2, 4);
  const std::vector<Shot> shots = shots_of_scan(*source, 2, degrees(90));
  EXPECT_THAT(captions(shots), ElementsAre("0 v0\nheading 90", "0 v0\nheading 270",
                                           "1 v1\nheading 90", "1 v1\nheading 270"));
  EXPECT_EQ(shots[2].viewpoint, "v1");
}

TEST(Shots, OfAPathLookAhead) {
  tasks::ReferencePath path;
  path.viewpoints = {ViewpointIndex(0), ViewpointIndex(1), ViewpointIndex(2)};
  path.heading = degrees(10);
  EXPECT_THAT(captions(shots_of_path(row(), path)),
              ElementsAre("start v0\nheading 10", "0 v0\nheading 90", "1 v1\nheading 90",
                          "goal v2\nheading 90"));
}

TEST(Shots, OfATrajectoryLookAsTheAgentDid) {
  tasks::Trajectory walk;
  walk.points = {{ViewpointIndex(0), degrees(180), degrees(-30)},
                 {ViewpointIndex(1), degrees(359.7), {}}};
  EXPECT_THAT(captions(shots_of_trajectory(row(), walk, {})),
              ElementsAre("0 v0\nheading 180, -30", "1 v1\nheading 0"));
  for (tasks::TrajectoryPoint& point : walk.points) point.heading = point.elevation = Radians(0);
  EXPECT_THAT(captions(shots_of_trajectory(row(), walk, {})),
              ElementsAre("0 v0\nheading 90", "1 v1\nheading 90"));
}

TEST(Shots, AreDrawnInTheirOrder) {
  const auto source = scan::testing::memory_panoramas("row", 2, 4);
  const auto renderer =
      render::make_renderer(std::make_shared<render::FaceCache>(scan::PanoramaSet::of({source})));
  const auto shots = shots_of_scan(*source, 10, Radians(0));  // more than a batch
  std::size_t done = 0;
  const auto pictures = draw_shots(*renderer, ScanIndex(), *source, shots, {8, 6, degrees(60)},
                                   [&](std::size_t n, std::size_t) { done = n; });
  ASSERT_EQ(pictures.size(), 20U);
  EXPECT_EQ(done, 20U);
  EXPECT_EQ(pictures[7].picture.width, 8U);
  EXPECT_EQ(pictures[7].picture.height, 6U);
  EXPECT_EQ(pictures[7].caption, shots[7].caption);
  EXPECT_NE(pictures[0].picture.pixels, pictures[10].picture.pixels);
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
