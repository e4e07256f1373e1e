#include "enfilade/scan/panorama_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/scan/data_root.h"
#include "tests/support/colour_texel.h"
#include "tests/support/panoramas.h"

namespace enfilade::scan {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(Poses, AreTheUpperLeftPartAndTheLastColumn) {
  Connectivity c = testing::row_of_viewpoints("scan", 2);
  c.entries[1].included = false;
  const std::vector<PanoramaPose> poses = poses_of(c);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[1].viewpoint, "v1");
  EXPECT_EQ(poses[1].position, (Vec3d{1, 0, 1.5}));
  EXPECT_FALSE(poses[1].included);
  // A level camera that looks along +y: its forward axis is the world's y, its down axis -z.
  EXPECT_EQ(poses[0].world_from_panorama * Vec3d(0, 0, 1), (Vec3d{0, 1, 0}));
  EXPECT_EQ(poses[0].world_from_panorama * Vec3d(0, 1, 0), (Vec3d{0, 0, -1}));
}

TEST(Poses, ThatAreNoRotationAreRefused) {
  const Connectivity good = testing::row_of_viewpoints("scan", 2);
  Connectivity mirrored = good, scaled = good, infinite = good, rounded = good;
  for (const std::size_t i : {0U, 4U, 8U}) mirrored.entries[1].pose[i] *= -1;
  for (const std::size_t i : {0U, 4U, 8U}) scaled.entries[1].pose[i] *= 1.01;
  infinite.entries[1].pose[0] = std::nan("");
  rounded.entries[1].pose[0] = 0.9999996;
  for (const Connectivity* bad : {&mirrored, &scaled, &infinite}) {
    EXPECT_THAT([&] { poses_of(*bad); },
                ThrowsMessage<InvalidInput>(AllOf(HasSubstr("$[1].pose"), HasSubstr("\"v1\""))));
  }
  EXPECT_EQ(poses_of(rounded).size(), 2U);
}

TEST(Poses, OfTheRealBuildingsAreRotations) {
  const auto root = DataRoot::from_environment();
  if (!root) GTEST_SKIP() << "ENFILADE_DATA is not set: no real graphs";
  std::size_t n = 0;
  for (const std::string& scan : load_scan_list(root->connectivity())) {
    n += poses_of(load_connectivity(root->connectivity(), scan)).size();
  }
  EXPECT_GE(n, 10'000U);
}

TEST(MakePanorama, HasAllLayersAndNothingInThem) {
  const Panorama p = make_panorama(3);
  EXPECT_EQ(p.sizes(), (FaceSizes{3, 3, 3, 3}));
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    EXPECT_EQ(p.colour[k], image::Image8(3, 3, 3));
    EXPECT_EQ(p.depth[k], image::Image16(3, 3, 1));
    EXPECT_EQ(p.classes[k], image::Image16(3, 3, 1));
    EXPECT_EQ(p.instances[k], image::Image32(3, 3, 1));
  }
  EXPECT_NO_THROW(MemoryPanoramas(testing::row_of_viewpoints("scan", 1), {p}));
}

TEST(MemoryPanoramas, FindViewpointsById) {
  const auto source = testing::memory_panoramas("scan", 3, 4);
  EXPECT_EQ(source->size(), 3U);
  EXPECT_EQ(source->scan(), "scan");
  EXPECT_EQ(source->find("v2"), ViewpointIndex(2));
  EXPECT_EQ(source->find("v3"), std::nullopt);
  EXPECT_EQ(source->at("v0"), ViewpointIndex(0));
  EXPECT_THAT([&] { source->at("nowhere"); },
              ThrowsMessage<LookupError>(
                  AllOf(HasSubstr("\"nowhere\""), HasSubstr("\"scan\""), HasSubstr("<memory>"))));
}

TEST(MemoryPanoramas, ComeBackAsTheyWere) {
  const Panorama first = testing::panorama(8, 1);
  Panorama second;  // colour only
  second.colour = testing::panorama(4, 2).colour;
  const MemoryPanoramas source(testing::row_of_viewpoints("scan", 3), {first, second, {}});
  EXPECT_EQ(source.face_sizes(ViewpointIndex(0)), (FaceSizes{8, 8, 8, 8}));
  EXPECT_EQ(source.face_sizes(ViewpointIndex(1)), (FaceSizes{4, 0, 0, 0}));
  EXPECT_EQ(source.face_sizes(ViewpointIndex(2)), (FaceSizes{0, 0, 0, 0}));
  const Panorama read = read_panorama(source, ViewpointIndex(0));
  EXPECT_EQ(read.colour, first.colour);
  EXPECT_EQ(read.depth, first.depth);
  EXPECT_EQ(read.classes, first.classes);
  EXPECT_EQ(read.instances, first.instances);
  EXPECT_EQ(read_panorama(source, ViewpointIndex(1)).colour, second.colour);
  EXPECT_EQ(read_panorama(source, ViewpointIndex(2)).sizes(), FaceSizes{});
}

TEST(MemoryPanoramas, PutTheNeighboursTexelsAroundAFace) {
  const auto source = testing::memory_panoramas("scan", 1, 4);
  testing::BorderedMap map(4);
  source->read_colour(ViewpointIndex(0), kAllFaces, map.faces());
  const Panorama truth = read_panorama(*source, ViewpointIndex(0));
  // Right of the front face begins the right face.
  const auto beyond = image::colour_texel(map.cells(index(CubeFace::kFront)).data(), 4, 4, 2);
  const std::uint8_t* neighbour = truth.colour[index(CubeFace::kRight)].at(0, 2);
  EXPECT_TRUE(std::ranges::equal(beyond, std::span(neighbour, 3)));
}

TEST(MemoryPanoramas, LeaveFacesThatNobodyWantsAlone) {
  const auto source = testing::memory_panoramas("scan", 1, 4);
  std::array<std::uint16_t*, kCubeFaces> buffers{};
  std::vector<std::uint16_t> up(16);
  buffers[index(CubeFace::kUp)] = up.data();
  source->read_16(Layer::kDepth, ViewpointIndex(0), FaceMask{1}, buffers);
  EXPECT_EQ(up, read_panorama(*source, ViewpointIndex(0)).depth[0].pixels);
}

TEST(MemoryPanoramas, SayWhichLayerIsMissing) {
  Panorama colour_only;
  colour_only.colour = testing::panorama(4, 2).colour;
  const MemoryPanoramas source(testing::row_of_viewpoints("scan", 1), {colour_only});
  EXPECT_THAT([&] { source.read_16(Layer::kClass, ViewpointIndex(0), kAllFaces, {}); },
              ThrowsMessage<LookupError>(AllOf(HasSubstr("no class"), HasSubstr("\"v0\""))));
  EXPECT_THROW(source.read_instances(ViewpointIndex(0), kAllFaces, {}), LookupError);
}

TEST(MemoryPanoramas, RefusePicturesThatAreNoCubeMap) {
  const Panorama good = testing::panorama(4, 1);
  Panorama oblong = good, mixed = good, grey = good, five = good;
  oblong.depth[0] = image::Image16(4, 3, 1);
  mixed.classes[3] = image::Image16(8, 8, 1);
  grey.colour[2] = image::Image8(4, 4, 1);
  five.instances[5] = image::Image32();
  for (const Panorama& bad : {oblong, mixed, grey, five}) {
    EXPECT_THAT([&] { MemoryPanoramas(testing::row_of_viewpoints("scan", 1), {bad}); },
                ThrowsMessage<ArgumentError>(HasSubstr("viewpoint \"v0\"")));
  }
  EXPECT_THROW(MemoryPanoramas(testing::row_of_viewpoints("scan", 2), {good}), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
