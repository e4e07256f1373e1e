#include "apps/enfilade/picture_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/image/codecs.h"
#include "tests/support/graphs.h"

namespace enfilade::apps {
namespace EN_UNIT {

using scan::Layer;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// Three viewpoints, the first with colour and instances.
scan::MemoryPanoramas panoramas(const std::vector<std::string>& ids) {
  scan::Connectivity c =
      graph::testing::connectivity("row", std::vector<Vec3d>(ids.size(), Vec3d{0, 0, 1.5}), {});
  for (std::size_t i = 0; i < ids.size(); ++i) c.entries[i].id = ids[i];
  std::vector<scan::Panorama> pictures(ids.size());
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    pictures[0].colour[k] = image::Image8(4, 4, 3);
    pictures[0].instances[k] = image::Image32(4, 4, 1);
  }
  return {std::move(c), std::move(pictures)};
}

TEST(FindViewpoint, TakesIdsIndicesAndBeginnings) {
  const scan::MemoryPanoramas row = panoramas({"10aa", "10bb", "2cc", "2"});
  const auto found = [&](const char* text) { return find_viewpoint(row, text).at(); };
  EXPECT_EQ(found("10bb"), 1U);
  EXPECT_EQ(found("10b"), 1U);
  EXPECT_EQ(found("1"), 1U);  // a number below the count is an index
  EXPECT_EQ(found("2"), 3U);  // an id before anything else
  EXPECT_EQ(found("2c"), 2U);
  EXPECT_THAT([&] { (void)found("10"); },
              ThrowsMessage<LookupError>(HasSubstr("2 of scan row begin so: 10aa, 10bb")));
  EXPECT_THAT([&] { (void)found("4"); }, ThrowsMessage<LookupError>(HasSubstr("an index below 4")));
  EXPECT_THROW((void)found(""), LookupError);
}

TEST(ParseSize, TakesTwoNumbersOnly) {
  const Size size = parse_size("--size", "640x480");
  EXPECT_EQ(size.width, 640U);
  EXPECT_EQ(size.height, 480U);
  for (const char* text : {"", "x", "640", "640x", "x480", "0x1", "1x0", "640x480x3", "-1x5",
                           "16385x1", "6e2x4", "99999999999x1"}) {
    EXPECT_THROW((void)parse_size("--size", text), UsageError) << text;
  }
}

std::vector<std::string> paths(const std::string& outputs, const std::string& file) {
  std::vector<std::string> names;
  for (const PictureFile& one : picture_files({outputs, file, false})) names.push_back(one.path);
  return names;
}

TEST(PictureFiles, StandBesideEachOther) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(paths("depth", "a/b.png"), (Names{"a/b.png"}));
  EXPECT_EQ(paths("rgb,depth,class", "a/b.c.png"),
            (Names{"a/b.c.png", "a/b.c-depth.png", "a/b.c-class.png"}));
  EXPECT_EQ(paths("depth,instance", "b.jpg"), (Names{"b-depth.jpg", "b-instance.jpg"}));
  EXPECT_EQ(paths("class", "-"), (Names{"-"}));
}

TEST(RequireLayers, NamesWhatThereIs) {
  const scan::MemoryPanoramas row = panoramas({"a", "b"});
  const auto require = [&](std::size_t viewpoint, const char* outputs) {
    require_layers(row, ViewpointIndex(viewpoint), picture_files({outputs, "a.png"}));
  };
  EXPECT_NO_THROW(require(0, "rgb,instance"));
  EXPECT_THAT([&] { require(0, "rgb,depth"); },
              ThrowsMessage<LookupError>(AllOf(HasSubstr("--outputs depth: scan \"row\", viewpoint "
                                                         "\"a\": no depth in <memory>"),
                                               HasSubstr("this panorama has rgb, instance"))));
  EXPECT_THAT([&] { require(1, "rgb"); }, ThrowsMessage<LookupError>(HasSubstr("no pictures")));
}

image::Bytes bytes_of(const std::string& text) { return image::bytes_of(text); }

TEST(EncodeRaw, DepthKeepsItsValues) {
  Drawn drawn;
  drawn.depth = image::Image16(2, 1, 1);
  drawn.depth.pixels = {0, 40001};
  const std::string png = encode_raw(drawn, Layer::kDepth);
  EXPECT_EQ(image::decode_png16(bytes_of(png), "depth"), drawn.depth);
}

TEST(Encode, NameSaysHow) {
  const image::Image8 picture(8, 8, 3);
  EXPECT_EQ(encode(picture, "a.jpg").substr(0, 2), "\xff\xd8");
  EXPECT_EQ(encode(picture, "-").substr(1, 3), "PNG");
}

}  // namespace EN_UNIT
}  // namespace enfilade::apps
