#include "enfilade/scan/matterport_images.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/codecs.h"
#include "enfilade/scan/depth_skybox.h"
#include "tests/support/panoramas.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/zip_bytes.h"

namespace enfilade::scan {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using tests::TemporaryFolder;

constexpr std::uint32_t kSize = 16;
const std::string kSkybox = "matterport_skybox_images";

std::string text_of(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

std::string jpeg_of(const image::Image8& picture) {
  return text_of(image::encode_jpeg(picture, 90, true));
}

template <class T>
std::string png_of(const image::Image<T>& picture) {
  return text_of(image::encode_png(picture));
}

/// Files of a kind, by name.
using Files = std::vector<std::pair<std::string, std::string>>;

std::string rgba_of_instances(const Panorama& p) {
  const image::Image32 strip = image::join_strip(p.instances);
  image::Image8 rgba(strip.width, strip.height, 4);
  for (std::size_t i = 0; i < strip.pixels.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) {
      rgba.pixels[4 * i + c] = static_cast<std::uint8_t>(strip.pixels[i] >> 8 * c);
    }
  }
  return png_of(rgba);
}

Files strips_of(const std::string& viewpoint, const Panorama& p) {
  return {{viewpoint + "_skybox_small.jpg", jpeg_of(image::join_strip(p.colour))},
          {viewpoint + "_skybox_depth_small.png", png_of(image::join_strip(p.depth))},
          {viewpoint + "_skybox_class_small.png", png_of(image::join_strip(p.classes))},
          {viewpoint + "_skybox_instance_small.png", rgba_of_instances(p)}};
}

Files faces_of(const std::string& viewpoint, const Panorama& p) {
  Files files;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    files.emplace_back(fmt::format("{}_skybox{}_sami.jpg", viewpoint, k), jpeg_of(p.colour[k]));
  }
  return files;
}

/// A scan "house" of three viewpoints, of which v2 is excluded, and its files.
class MatterportImagesTest : public ::testing::Test {
 protected:
  MatterportImagesTest()
      : folder_(fmt::format("matterport_images_{}",
                            ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    Connectivity graph = testing::row_of_viewpoints("house", 3);
    graph.entries[2].included = false;
    fs::create_directory(root() / "connectivity");
    write_file_atomically(root() / "connectivity/house_connectivity.json", to_json(graph));
  }

  const fs::path& root() const { return folder_.path(); }
  fs::path skybox() const { return root() / "house" / kSkybox; }

  static void write(const fs::path& kind, const Files& files) {
    fs::create_directories(kind);
    for (const auto& [name, content] : files) write_file_atomically(kind / name, content);
  }
  static void write_zip(const fs::path& zip, const Files& files) {
    std::vector<testing::ZipEntry> entries;
    for (const auto& [name, content] : files) entries.push_back({"house/kind/" + name, content});
    fs::create_directories(zip.parent_path());
    write_file_atomically(zip, testing::zip_of(entries));
  }
  std::shared_ptr<const PanoramaSource> open() const {
    return open_matterport_images(root(), root() / "connectivity", "house");
  }
  template <class Expected>
  std::string refusal(const std::function<void(const PanoramaSource&)>& action) const {
    return tests::refusal<Expected>([&] { action(*open()); });
  }
  /// What reading v0 with these files says.
  template <class Expected>
  std::string refusal_of(const Files& files) const {
    fs::remove_all(root() / "house");
    write(skybox(), files);
    return refusal<Expected>([](const auto& source) { read_panorama(source, ViewpointIndex(0)); });
  }

 private:
  TemporaryFolder folder_;
};

constexpr ViewpointIndex kV0{0}, kV1{1}, kV2{2};

image::Image8 decoded(const std::string& jpeg) {
  return image::decode_jpeg(image::bytes_of(jpeg), "made");
}

TEST_F(MatterportImagesTest, ReadsStripsInEveryLayout) {
  const Panorama p = testing::panorama(kSize, 5);
  const Files files = strips_of("v0", p);
  const auto colour = image::split_strip(decoded(files[0].second));
  for (const fs::path place : {"house", "v1/scans/house", "scans/house", ""}) {
    for (const bool zipped : {false, true}) {
      const fs::path kind = root() / place / kSkybox;
      if (zipped) {
        write_zip(kind.string() + ".zip", files);
      } else {
        write(kind, files);
      }
      const auto source = open();
      EXPECT_EQ(source->scan(), "house");
      EXPECT_EQ(source->origin(), root().string());
      EXPECT_TRUE(source->reads_whole_panoramas());
      EXPECT_EQ(source->connectivity().entries.size(), 3U);
      EXPECT_FALSE(source->poses()[2].included);
      EXPECT_THAT(source->face_sizes(kV0), ElementsAre(kSize, kSize, kSize, kSize)) << kind;
      EXPECT_THAT(source->face_sizes(kV2), ElementsAre(0, 0, 0, 0));
      const Panorama read = read_panorama(*source, kV0);
      EXPECT_EQ(read.colour, colour) << kind;
      EXPECT_EQ(read.depth, p.depth) << kind;
      EXPECT_EQ(read.classes, p.classes) << kind;
      EXPECT_EQ(read.instances, p.instances) << kind;
      fs::remove_all(root() / place / kSkybox);
      fs::remove(kind.string() + ".zip");
    }
  }
}

TEST_F(MatterportImagesTest, ReadsFacesAndPrefersStrips) {
  const Panorama faces = testing::panorama(kSize, 1), strip = testing::panorama(kSize, 2);
  write(skybox(), faces_of("v0", faces));
  write(skybox(), faces_of("v1", faces));
  write(skybox(), {strips_of("v1", strip)[0]});
  const auto source = open();
  EXPECT_THAT(source->face_sizes(kV0), ElementsAre(kSize, 0, 0, 0));
  const auto read = read_panorama(*source, kV0);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    EXPECT_EQ(read.colour[k], decoded(jpeg_of(faces.colour[k])));
  }
  EXPECT_EQ(read_panorama(*source, kV1).colour,
            image::split_strip(decoded(jpeg_of(image::join_strip(strip.colour)))));
}

TEST_F(MatterportImagesTest, TakesEachFileFromTheFirstPlaceThatHasIt) {
  const Panorama p = testing::panorama(kSize, 1);
  write(skybox(), {strips_of("v0", p)[0]});
  write_zip(root() / "v1/scans/house" / (kSkybox + ".zip"), strips_of("v0", p));
  const auto source = open();
  EXPECT_THAT(source->face_sizes(kV0), ElementsAre(kSize, kSize, kSize, kSize));
  EXPECT_EQ(read_panorama(*source, kV0).depth, p.depth);
}

TEST_F(MatterportImagesTest, WritesWantedFacesWithTheirBorders) {
  write(skybox(), strips_of("v0", testing::panorama(kSize, 3)));
  const auto source = open();
  const auto faces = read_panorama(*source, kV0).colour;
  testing::BorderedMap found(kSize), expected(kSize);
  const FaceMask wanted = 1U << index(CubeFace::kRight) | 1U << index(CubeFace::kDown);
  source->read_colour(kV0, wanted, found.faces());
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    if ((wanted >> k & 1) != 0) {
      image::write_face(expected.faces()[k], faces[k]);
      image::write_border(expected.faces()[k], image::border_of(faces, cube_face(k)));
    }
    EXPECT_EQ(found.cells(k), expected.cells(k)) << "face " << k;
  }
}

TEST_F(MatterportImagesTest, ReadsGreyInstances) {
  image::Image16 strip(6 * kSize, kSize, 1);
  for (std::size_t i = 0; i < strip.pixels.size(); ++i) {
    strip.pixels[i] = static_cast<std::uint16_t>(40 * i);
  }
  write(skybox(), {{"v0_skybox_instance_small.png", png_of(strip)}});
  const auto instances = read_panorama(*open(), kV0).instances;
  EXPECT_EQ(*instances[0].at(3, 0), 120U);
  EXPECT_EQ(*instances[5].at(kSize - 1, kSize - 1), 40 * (strip.pixels.size() - 1));
}

TEST_F(MatterportImagesTest, SaysWhereItLookedForAScan) {
  EXPECT_THAT(refusal<LookupError>([](const auto&) {}),
              AllOf(HasSubstr("scan \"house\": no panoramas"), HasSubstr(skybox().string()),
                    HasSubstr((root() / "v1/scans/house" / kSkybox).string() + ".zip"),
                    HasSubstr((root() / "scans/house" / kSkybox).string()),
                    HasSubstr((root() / kSkybox).string() + ".zip")));
  fs::create_directories(root() / kSkybox);
  fs::remove(root() / "connectivity/house_connectivity.json");
  EXPECT_THAT(refusal<FileError>([](const auto&) {}), HasSubstr("house_connectivity.json"));
}

TEST_F(MatterportImagesTest, SaysWhereItLookedForAPanorama) {
  write(skybox(), strips_of("v0", testing::panorama(kSize, 1)));
  write_zip(root() / "house" / "undistorted_depth_images.zip", {{"v0_d0_0.png", "not asked"}});
  write_zip(root() / (kSkybox + ".zip"), {{"v0_skybox_small.jpg", "not asked"}});
  testing::BorderedMap room(kSize);
  std::array<std::uint16_t*, kCubeFaces> none{};
  EXPECT_THAT(
      refusal<LookupError>([&](const auto& s) { s.read_colour(kV1, kAllFaces, room.faces()); }),
      AllOf(HasSubstr("scan \"house\", viewpoint \"v1\": no colour; tried:"),
            HasSubstr((skybox() / "v1_skybox_small.jpg").string()),
            HasSubstr((skybox() / "v1_skybox<0..5>_sami.jpg").string()),
            HasSubstr((root() / kSkybox).string() + ".zip:v1_skybox_small.jpg")));
  EXPECT_THAT(
      refusal<LookupError>([&](const auto& s) { s.read_16(Layer::kDepth, kV1, kAllFaces, none); }),
      AllOf(HasSubstr("no depth"), HasSubstr("v1_skybox_depth_small.png"),
            HasSubstr("undistorted_depth_images.zip:v1_d<cam>_<yaw>.png")));
  EXPECT_THAT(
      refusal<LookupError>([&](const auto& s) { s.read_16(Layer::kClass, kV1, kAllFaces, none); }),
      HasSubstr("v1_skybox_class_small.png"));
  EXPECT_THAT(refusal<LookupError>([&](const auto& s) { s.read_instances(kV1, kAllFaces, {}); }),
              HasSubstr("v1_skybox_instance_small.png"));
  EXPECT_THAT(refusal<LookupError>([&](const auto& s) { s.colour_jpegs(kV1); }),
              HasSubstr("v1_skybox<0..5>_sami.jpg"));
}

TEST_F(MatterportImagesTest, NamesTheFaceThatIsMissingOrOfAnotherSize) {
  const Panorama p = testing::panorama(kSize, 1), larger = testing::panorama(2 * kSize, 1);
  Files files = faces_of("v0", p);
  files[4].second = faces_of("v0", larger)[4].second;
  EXPECT_THAT(refusal_of<InvalidInput>(files),
              AllOf(HasSubstr((skybox() / "v0_skybox4_sami.jpg").string() +
                              ": scan \"house\", viewpoint \"v0\": 32 pixels wide, but"),
                    HasSubstr("v0_skybox0_sami.jpg is 16"), HasSubstr("[mixed-sizes]")));
  files.erase(files.begin() + 4);
  EXPECT_THAT(refusal_of<FileError>(files),
              AllOf(HasSubstr("v0_skybox4_sami.jpg: no such file, though 5 of the panorama's 6"),
                    HasSubstr((skybox() / "v0_skybox4_sami.jpg").string()),
                    HasSubstr("(scan \"house\", viewpoint \"v0\")")));
  files = faces_of("v0", p);
  files[0].second = jpeg_of(image::Image8(kSize, kSize / 2, 3));
  EXPECT_THAT(refusal_of<InvalidInput>(files), HasSubstr("16 x 8 pixels, not square [bad-face]"));
}

TEST_F(MatterportImagesTest, RefusesBrokenFilesByName) {
  const Panorama p = testing::panorama(kSize, 1);
  const Files good = strips_of("v0", p);
  for (std::size_t i = 0; i < good.size(); ++i) {
    Files files = good;
    files[i].second.resize(files[i].second.size() / 2);
    EXPECT_THAT(refusal_of<InvalidInput>(files), HasSubstr((skybox() / good[i].first).string() +
                                                           ": scan \"house\", viewpoint \"v0\": "));
    files[i].second = "no picture";
    EXPECT_THAT(refusal_of<InvalidInput>(files), HasSubstr(good[i].first + ": scan \"house\""));
  }
}

TEST_F(MatterportImagesTest, RefusesPicturesOfAnotherKind) {
  const Panorama p = testing::panorama(kSize, 1);
  const auto refusal_with = [&](std::size_t i, const std::string& content) {
    Files files = strips_of("v0", p);
    files[i].second = content;
    return refusal_of<InvalidInput>(files);
  };
  EXPECT_THAT(refusal_with(0, jpeg_of(p.colour[0])),
              HasSubstr("16 x 16 pixels, not six square faces side by side [bad-strip]"));
  EXPECT_THAT(refusal_with(1, png_of(p.depth[0])), HasSubstr("[bad-strip]"));
  EXPECT_THAT(refusal_with(1, png_of(image::Image8(6 * kSize, kSize, 1))),
              HasSubstr("1 channels of 8 bits, not greyscale of 16 bits [bad-bits]"));
  EXPECT_THAT(refusal_with(2, png_of(image::Image8(6 * kSize, kSize, 3))),
              HasSubstr("3 channels, not greyscale"));
  EXPECT_THAT(refusal_with(3, png_of(image::Image8(6 * kSize, kSize, 3))),
              HasSubstr("neither greyscale nor RGBA of 8 bits"));
  EXPECT_EQ(refusal_with(2, png_of(image::Image8(6 * kSize, kSize, 1))), "accepted");
}

TEST_F(MatterportImagesTest, NoticesFilesThatChangeTheirSize) {
  write(skybox(), strips_of("v0", testing::panorama(kSize, 1)));
  const auto source = open();
  const FaceSizes before = source->face_sizes(kV0);
  write(skybox(), strips_of("v0", testing::panorama(2 * kSize, 1)));
  EXPECT_EQ(source->face_sizes(kV0), before) << "buffers are made for it";
  std::vector<std::uint16_t> room(kSize * kSize);
  std::array<std::uint16_t*, kCubeFaces> buffers;
  buffers.fill(room.data());
  try {
    source->read_16(Layer::kDepth, kV0, kAllFaces, buffers);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("depth: faces of 32 texels, but of 16 when first looked"));
  }
}

TEST_F(MatterportImagesTest, GivesTheFilesOwnJpegs) {
  const Panorama p = testing::panorama(kSize, 1);
  const Files faces = faces_of("v0", p);
  write(skybox(), faces);
  write(skybox(), strips_of("v1", p));
  const auto source = open();
  const auto verbatim = source->colour_jpegs(kV0);
  const auto cut = source->colour_jpegs(kV1);
  ASSERT_TRUE(verbatim && cut);
  const auto strip = read_panorama(*source, kV1).colour;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    EXPECT_EQ((*verbatim)[k], faces[k].second);
    EXPECT_EQ(decoded((*cut)[k]), strip[k]);
  }
  // Blocks of 8 x 8 pixels do not end at the edges of faces of 12.
  write(skybox(), strips_of("v0", testing::panorama(12, 1)));
  EXPECT_EQ(open()->colour_jpegs(kV0), std::nullopt);
}

TEST_F(MatterportImagesTest, TellsWhenAFileChanges) {
  write(skybox(), strips_of("v0", testing::panorama(kSize, 1)));
  const std::string before = open()->state();
  EXPECT_EQ(open()->state(), before);
  write(skybox(), {strips_of("v1", testing::panorama(kSize, 1))[1]});
  EXPECT_NE(open()->state(), before);
}

TEST_F(MatterportImagesTest, IsReadByManyThreads) {
  Files files = strips_of("v0", testing::panorama(kSize, 1));
  for (auto& file : strips_of("v1", testing::panorama(kSize, 2))) files.push_back(file);
  write_zip(root() / "house" / (kSkybox + ".zip"), files);
  const auto source = open();
  const Panorama alone[] = {read_panorama(*open(), kV0), read_panorama(*open(), kV1)};
  parallel_for(64, 1, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Panorama p = read_panorama(*source, ViewpointIndex(i % 2));
      if (p.colour != alone[i % 2].colour || p.instances != alone[i % 2].instances) {
        throw ArgumentError("wrong content");
      }
    }
  });
}

// --- depth out of undistorted images ----------------------------------------------------------

/// Two cameras of v0, ahead and behind, that see walls at 3 m and 5 m.
struct Undistorted {
  std::string conf =
      "dataset matterport\nn_images 2\nintrinsics_matrix 20 0 15.5 0 20 15.5 0 0 1\n"
      "scan v0_d1_0.png v0_i1_0.jpg  1 0 0 0  0 0 -1 0.05  0 1 0 1.5  0 0 0 1\n"
      "scan v0_d1_3.png v0_i1_3.jpg -1 0 0 0  0 0 1 -0.05  0 1 0 1.5  0 0 0 1\n";
  image::Image16 ahead{32, 32, 1}, behind{32, 32, 1};

  Undistorted() {
    ahead.pixels.assign(ahead.pixels.size(), 12000);
    behind.pixels.assign(behind.pixels.size(), 20000);
    *ahead.at(16, 16) = 0;
  }
  Files images() const { return {{"v0_d1_0.png", png_of(ahead)}, {"v0_d1_3.png", png_of(behind)}}; }
};

TEST_F(MatterportImagesTest, BuildsDepthOutOfUndistortedImages) {
  const Undistorted made;
  write(skybox(), faces_of("v0", testing::panorama(kSize, 1)));
  write(skybox(), faces_of("v1", testing::panorama(kSize, 1)));
  write_zip(root() / "house/undistorted_camera_parameters.zip", {{"house.conf", made.conf}});
  write(root() / "house/undistorted_depth_images", made.images());
  const auto source = open();
  EXPECT_THAT(source->face_sizes(kV0), ElementsAre(kSize, kSize, 0, 0));
  EXPECT_THAT(source->face_sizes(kV1), ElementsAre(kSize, 0, 0, 0)) << "has no cameras";
  const Panorama read = read_panorama(*source, kV0);
  const auto cameras = parse_undistorted_cameras(made.conf, "made");
  const std::vector<DepthImage> images{{cameras[0], made.ahead}, {cameras[1], made.behind}};
  EXPECT_EQ(read.depth, fill_holes(depth_skybox(images, source->poses()[0], kSize), read.colour));
  // The wall ahead is at 3 m from a camera that stands 5 cm nearer to it than the eye.
  EXPECT_NEAR(*read.depth[index(CubeFace::kFront)].at(8, 8), 12200, .01 * 12200);
  EXPECT_NEAR(*read.depth[index(CubeFace::kBack)].at(8, 8), 20200, .01 * 20200);
}

TEST_F(MatterportImagesTest, PrefersADepthStrip) {
  const Panorama p = testing::panorama(kSize, 1);
  const Undistorted made;
  write(skybox(), strips_of("v0", p));
  write(root() / "house/undistorted_camera_parameters", {{"house.conf", made.conf}});
  write(root() / "house/undistorted_depth_images", made.images());
  EXPECT_EQ(read_panorama(*open(), kV0).depth, p.depth);
}

TEST_F(MatterportImagesTest, NamesTheUndistortedFileThatIsMissingOrBroken) {
  Undistorted made;
  const fs::path conf = root() / "house/undistorted_camera_parameters";
  const fs::path depth = root() / "house/undistorted_depth_images";
  write(skybox(), faces_of("v0", testing::panorama(kSize, 1)));
  write(conf, {{"house.conf", made.conf}});
  write(depth, {made.images()[0]});
  const auto read = [](const PanoramaSource& source) { read_panorama(source, kV0); };
  EXPECT_THAT(refusal<FileError>(read),
              AllOf(HasSubstr("v0_d1_3.png: no such file, though house.conf lists it"),
                    HasSubstr((depth / "v0_d1_3.png").string()), HasSubstr("viewpoint \"v0\"")));
  write(depth, {{"v0_d1_3.png", png_of(image::Image8(32, 32, 1))}});
  EXPECT_THAT(refusal<InvalidInput>(read),
              AllOf(HasSubstr((depth / "v0_d1_3.png").string()), HasSubstr("of 16 bits")));
  write(conf, {{"house.conf", "scan\n"}});
  EXPECT_THAT(refusal<InvalidInput>(read),
              HasSubstr((conf / "house.conf").string() +
                        ": scan \"house\", viewpoint \"v0\", line 1: \"scan\" has 0 fields"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
