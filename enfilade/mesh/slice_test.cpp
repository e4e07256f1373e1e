#include "enfilade/mesh/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/made_meshes.h"

namespace enfilade::mesh {
namespace EN_UNIT {

double total(const std::vector<SliceLine>& lines) {
  double metres = 0;
  for (const SliceLine& line : lines) metres += length(line.to - line.from);
  return metres;
}

TEST(Slice, BoxGivesItsOutline) {
  const auto lines = slice(testing::Maker().box({1, 2, 0}, {4, 4, 1}).mesh, 0.25F);
  EXPECT_EQ(lines.size(), 8U);            // two triangles of each of four sides
  EXPECT_NEAR(total(lines), 10.0, 1e-5);  // 2 (3 + 2)
  for (const SliceLine& line : lines) {
    for (const Vec3f p : {line.from, line.to}) {
      EXPECT_EQ(p.z, 0.25F);
      EXPECT_TRUE(p.x == 1 || p.x == 4 || p.y == 2 || p.y == 4);
    }
    EXPECT_EQ(line.object, kNoObject);
  }
}

TEST(Slice, CornersInThePlaneCountOnceAndLevelTrianglesNever) {
  const Mesh box = testing::Maker().box({0, 0, 0}, {1, 1, 1}).mesh;
  EXPECT_NEAR(total(slice(box, 1)), 4.0, 1e-6);  // its sides reach up to there; its top lies in it
  EXPECT_TRUE(slice(box, 0).empty());            // nothing is below
  EXPECT_TRUE(slice(box, 1.5F).empty());
}

TEST(Slice, NamesTheObject) {
  Mesh boxes = testing::Maker().box({0, 0, 0}, {1, 1, 1}).box({2, 0, 0}, {3, 1, 2}).mesh;
  boxes.objects = {{"stool", 0, 0}, {"post", 0, 0}};
  for (std::size_t t = 0; t < boxes.triangles.size(); ++t) {
    boxes.triangle_object.push_back(t < boxes.triangles.size() / 2 ? 0U : 1U);
  }
  const auto lines = slice(boxes, 1.5F);
  ASSERT_EQ(lines.size(), 8U);
  EXPECT_TRUE(std::ranges::all_of(lines, [](const SliceLine& l) { return l.object == 1; }));
}

TEST(Slice, SlopesGiveTheLineAtTheirHeight) {
  const auto lines = slice(testing::Maker().ramp(0, 0, 4, 2, 0, 2).mesh, 0.5F);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_NEAR(total(lines), 2.0, 1e-6);
  for (const SliceLine& line : lines) EXPECT_NEAR(line.from.x, 1.0, 1e-6);
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
