#include "enfilade/exports/picture_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/scan/store.h"
#include "tests/support/made_panoramas.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::exports {
namespace EN_UNIT {

using ::testing::HasSubstr;

class PictureFiles : public ::testing::Test {
 protected:
  PictureFiles() : folder_("exports"), data_((pack_into(folder_.path()), folder_.path())) {}

  static void pack_into(const std::filesystem::path& folder) {
    const scan::MemoryPanoramas panoramas(
        scan::testing::row_of_viewpoints("made", 2),
        {render::testing::made_panorama(32), render::testing::made_panorama(32)});
    scan::pack(panoramas, folder, {.colour = scan::ColourCoding::kRaw});
  }
  std::filesystem::path place(const std::string& name) const { return folder_.path() / name; }

  tests::TemporaryFolder folder_;
  dataset::Dataset data_;
};

TEST_F(PictureFiles, ViewsAreJpegsOfTheirNumber) {
  const ViewPicturesOptions small{.camera = {32, 24, degrees(60)}};
  const ViewPicturesReport first = write_view_pictures(data_, place("views"), small);
  EXPECT_EQ(first.viewpoints, 2U);
  EXPECT_EQ(first.kept, 0U);
  const std::filesystem::path at = place("views") / "made" / "v1";
  for (const char* name : {"0.jpg", "35.jpg"}) {
    const std::string jpeg = read_file(at / name);
    EXPECT_EQ(image::jpeg_shape(image::bytes_of(jpeg), name), (image::Shape{32, 24, 3, 8}));
  }
  EXPECT_FALSE(file_exists(at / "36.jpg"));
  std::filesystem::remove_all(at);
  const ViewPicturesReport second = write_view_pictures(data_, place("views"), small);
  EXPECT_EQ(second.viewpoints, 2U);
  EXPECT_EQ(second.kept, 1U);
  EXPECT_TRUE(file_exists(at / "35.jpg"));
  EXPECT_THAT(tests::refusal<FileError>([&] { write_view_pictures(data_, place("views")); }),
              HasSubstr("the folder has other pictures"));
}

TEST_F(PictureFiles, FollowNoLinkThatSomebodyPutIntoTheFolder) {
  const std::filesystem::path outside = place("outside");
  std::filesystem::create_directory(outside);
  std::filesystem::create_directory(place("views"));
  std::filesystem::create_directory_symlink(outside, place("views") / "made");
  const ViewPicturesOptions small{.camera = {32, 24, degrees(60)}};
  EXPECT_THROW(write_view_pictures(data_, place("views"), small), FileError);
  // Parts of a job that the link's target claims to have begun.
  std::filesystem::create_directory_symlink(outside, place("depth.hdf5.parts"));
  write_gridmm_depth(data_, place("depth.hdf5"));
  EXPECT_TRUE(file_exists(place("depth.hdf5")));
  EXPECT_TRUE(std::filesystem::is_empty(outside));
}

TEST_F(PictureFiles, DepthsAreWrittenForEachViewpoint) {
  std::size_t last = 0;
  const ExportOptions options{.progress = [&](std::size_t done, std::size_t total) {
    EXPECT_EQ(total, 2U);
    last = done;
  }};
  write_gridmm_depth(data_, place("depth.hdf5"), options);
  EXPECT_EQ(last, 2U);
  write_bevbert_depth(data_, place("depth_14x14.hdf5"));
  write_bevbert_classes(data_, place("semantic41_14x14.hdf5"));
  for (const char* name : {"depth.hdf5", "depth_14x14.hdf5", "semantic41_14x14.hdf5"}) {
    EXPECT_TRUE(file_exists(place(name)));
    EXPECT_FALSE(file_exists(place(std::string(name) + ".parts")));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::exports
