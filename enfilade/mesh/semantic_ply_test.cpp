#include "enfilade/mesh/semantic_ply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "enfilade/core/errors.h"

namespace enfilade::mesh {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// A square of one object and a triangle of another.
std::string semantic_ply(const std::string& ids, const std::string& first,
                         const std::string& second,
                         const std::string& colours =
                             "property uchar red\nproperty uchar green\n"
                             "property uchar blue\n") {
  const std::string rgb = colours.empty() ? "\n" : " 9 9 9\n";
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\n"
      "property float y\nproperty float z\n" +
      colours + "element face 2\nproperty list uchar int vertex_indices\n" + ids + "end_header\n";
  for (const char* corner : {"0 0 1", "2 0 1", "2 2 1", "0 2 1", "4 0 1"}) text += corner + rgb;
  return text + "4 0 1 2 3 " + first + "\n3 1 4 2 " + second + "\n";
}
constexpr const char* kInt = "property int object_id\n";

TEST(SemanticPly, InstancesAreIds) {
  const Mesh mesh = parse_semantic_ply(semantic_ply(kInt, "7", "0"), "a_semantic.ply");
  EXPECT_THAT(mesh.triangle_object, ElementsAre(6, 6, kNoObject));
  EXPECT_EQ(mesh.objects.size(), 7U);
  EXPECT_EQ(mesh.positions[4], (Vec3f{4, 0, 1})) << "the file's axes";
  EXPECT_TRUE(mesh.colours.empty());
}

TEST(SemanticPly, IdsHaveSixteenBits) {
  const auto object = [](const std::string& type, const std::string& id) {
    const std::string text = semantic_ply("property " + type + " object_id\n", id, "1");
    return parse_semantic_ply(text, "a_semantic.ply").triangle_object[0] + 1;
  };
  EXPECT_EQ(object("int", "-1"), 65535U);
  EXPECT_EQ(object("short", "-1"), 65535U);
  EXPECT_EQ(object("char", "-1"), 255U);
  EXPECT_EQ(object("uint", "65535"), 65535U);
}

TEST(SemanticPly, SaysWhatIsWrong) {
  const auto parse = [](const std::string& text) {
    return [text] { (void)parse_semantic_ply(text, "a_semantic.ply"); };
  };
  EXPECT_THAT(parse(semantic_ply(kInt, "1", "65536")),
              ThrowsMessage<InvalidInput>(HasSubstr("object_id 65536, not a whole number up to")));
  EXPECT_THAT(parse(semantic_ply(kInt, "0.5", "1")),
              ThrowsMessage<InvalidInput>(HasSubstr("a_semantic.ply: face 0")));
  EXPECT_THAT(parse(semantic_ply(kInt, "nan", "1")), ThrowsMessage<InvalidInput>(HasSubstr("nan")));
  EXPECT_THAT(parse(semantic_ply("property float object_id\n", "1", "1")),
              ThrowsMessage<InvalidInput>(HasSubstr("no property object_id of whole numbers")));
  EXPECT_THAT(parse(semantic_ply("property int other\n", "1", "1")),
              ThrowsMessage<InvalidInput>(HasSubstr("no property object_id")));
  EXPECT_THAT(parse(semantic_ply(kInt, "1", "1", "")),
              ThrowsMessage<InvalidInput>(HasSubstr("no red, green and blue")));
  EXPECT_THROW(parse("ply\n")(), InvalidInput);
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
