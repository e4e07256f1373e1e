#include "enfilade/geometry/triangle_draw.h"

#include <gtest/gtest.h>

namespace enfilade {
namespace EN_UNIT {

TEST(TriangleDraw, IsUniformByArea) {
  // A right triangle of 0.5 m2, and one of 1.5 m2 that lies 10 m above.
  const TriangleDraw triangles({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}},  //
                                {{{0, 0, 10}, {3, 0, 10}, {0, 1, 10}}}});
  Rng rng(1);
  constexpr int kDraws = 20000;
  int above = 0;
  Vec3d sum;
  for (int k = 0; k < kDraws; ++k) {
    const Vec3f p = triangles.draw(rng).value();
    if (p.z < 5) {
      EXPECT_TRUE(p.x >= 0 && p.y >= 0 && p.x + p.y <= 1.000001F) << p.x << ' ' << p.y;
      continue;
    }
    ++above;
    sum = sum + to_double(p);
  }
  // Four standard deviations: sqrt(0.75 * 0.25 / 20,000) of the share, 3 / sqrt(18 * 15,000) of x.
  EXPECT_NEAR(static_cast<double>(above) / kDraws, 0.75, 4 * 0.0031);
  EXPECT_NEAR(sum.x / above, 1, 4 * 0.0058);
  EXPECT_NEAR(sum.y / above, 1.0 / 3, 4 * 0.0020);
}

TEST(TriangleDraw, HasNoPointWithoutTriangles) {
  Rng rng(1);
  EXPECT_FALSE(TriangleDraw({}).draw(rng).has_value());
}

}  // namespace EN_UNIT
}  // namespace enfilade
