#include "tests/conformance/synthetic.h"

#include <gmock/gmock.h>
#include <array>

namespace enfilade::tests {
namespace EN_UNIT {

using ::testing::ElementsAre;

// Published with the recordings.
TEST(Synthetic, HashesAreThosePublished) {
  EXPECT_EQ(name_hash("a"), 0xaf63dc4c8601ec8cU);
  EXPECT_EQ(name_hash("ZMojNkEp431_2f4d90acd4024c269fb0efe49a8ac540"), 0x5838d88bd5abef5eU);
}

TEST(Synthetic, ViewsAndObjectsAreThosePublished) {
  std::array<float, 32> view{};
  synthetic_view("ZMojNkEp431", "2f4d90acd4024c269fb0efe49a8ac540", 0, view);
  EXPECT_FLOAT_EQ(view[0], -0.6241801F);
  EXPECT_FLOAT_EQ(view[1], -0.8529953F);
  EXPECT_FLOAT_EQ(view[2], -0.8961148F);
  synthetic_view("ZMojNkEp431", "2f4d90acd4024c269fb0efe49a8ac540", 35, view);
  EXPECT_FLOAT_EQ(view[31], -0.88052297F);
  EXPECT_EQ(view[31], synthetic_value("ZMojNkEp431_2f4d90acd4024c269fb0efe49a8ac540",
                                      std::uint64_t{65536} * 35 + 31));
  synthetic_object("17DRP5sb8fy", "00ebbf3782c64d74aaf7dd39cd561175", "67", view);
  EXPECT_FLOAT_EQ(view[0], -0.6098441F);
  EXPECT_FLOAT_EQ(view[1], -0.470446F);
  EXPECT_FLOAT_EQ(view[2], 0.2328974F);
}

TEST(Synthetic, WordsAreThosePublished) {
  EXPECT_THAT(synthetic_words("Walk past the  table. Wait\tthere"),
              ElementsAre(1, 97, 33, 60, 176, 159, 260, 2));
  EXPECT_THAT(synthetic_words("Walk past the", 3), ElementsAre(1, 97, 33));
  EXPECT_THAT(synthetic_words(" \n"), ElementsAre(1, 2));
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
