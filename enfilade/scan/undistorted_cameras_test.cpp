#include "enfilade/scan/matterport_cameras.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"

namespace enfilade::scan {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr const char* kPose = "1 0 0 2.5  0 0 -1 3  0 1 0 1.25  0 0 0 1";

std::string conf() {
  return "dataset matterport\n"
         "n_images 3\n"
         "depth_directory undistorted_depth_images\n"
         "color_directory undistorted_color_images\n"
         "\n"
         "intrinsics_matrix 1074.5 0 629.25  0 1073 509.5  0 0 1\r\n"
         "scan a1_d0_0.png a1_i0_0.jpg " +
         std::string(kPose) +
         "\n"
         "scan a1_d0_1.png a1_i0_1.jpg 0.36 0.48 -0.8 1e0 -0.8 0.6 0 -2 0.48 0.64 0.6 0 0 0 0 1\n"
         "# the next camera\n"
         "intrinsics_matrix 1075 0 630 0 1076 511 0 0 1\n"
         "image b_d2_d2_5.png b_d2_i2_5.jpg " +
         std::string(kPose);
}

std::string edited(const std::string& from, const std::string& to) {
  std::string text = conf();
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string faults_of(const std::string& text) {
  try {
    parse_undistorted_cameras(text, "s.conf");
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST(UndistortedCameras, AreReadAsTheyStand) {
  const std::vector<UndistortedCamera> cameras = parse_undistorted_cameras(conf(), "s.conf");
  ASSERT_EQ(cameras.size(), 3U);
  const UndistortedCamera& first = cameras[0];
  EXPECT_EQ(first.depth_file, "a1_d0_0.png");
  EXPECT_EQ(first.colour_file, "a1_i0_0.jpg");
  EXPECT_EQ(first.viewpoint(), "a1");
  EXPECT_EQ(first.fx, 1074.5);
  EXPECT_EQ(first.fy, 1073);
  EXPECT_EQ(first.cx, 629.25);
  EXPECT_EQ(first.cy, 509.5);
  EXPECT_EQ(first.position, (Vec3d{2.5, 3, 1.25}));
  EXPECT_EQ(first.world_from_camera * Vec3d({0, 0, -1}), (Vec3d{0, 1, 0})) << "it looks north";
  EXPECT_EQ(cameras[1].fx, 1074.5) << "intrinsics hold until the next ones";
  EXPECT_EQ(cameras[1].world_from_camera.m,
            (std::array<double, 9>{.36, .48, -.8, -.8, .6, 0, .48, .64, .6}));
  EXPECT_EQ(cameras[2].viewpoint(), "b_d2") << "`image` is `scan`";
  EXPECT_EQ(cameras[2].cy, 511);
}

TEST(UndistortedCameras, PassOverCommandsWithoutEffectOnPictures) {
  EXPECT_EQ(faults_of(conf() + "\nrectangle 1 2 3\nmesh m.ply\ntexture_directory t\n"), "accepted");
  EXPECT_EQ(faults_of(""), "accepted");
  EXPECT_THAT(parse_undistorted_cameras("n_images 0", "s.conf"), IsEmpty());
}

TEST(UndistortedCameras, NameLineValueAndWhatIsAllowed) {
  EXPECT_THAT(faults_of(edited("dataset matterport", "dataset sun3d")),
              HasSubstr("s.conf: line 1: dataset \"sun3d\", not \"matterport\""));
  EXPECT_THAT(faults_of(edited("n_images 3", "n_images -1")),
              HasSubstr("line 2: n_images \"-1\", not a whole number"));
  EXPECT_THAT(faults_of(edited("n_images 3", "n_images 4")),
              HasSubstr("line 12: the file ends after 3 scan lines, not 4"));
  EXPECT_THAT(faults_of(edited("n_images 3", "n_pictures 3")),
              HasSubstr("line 2: \"n_pictures\" is no command; allowed: dataset, n_images"));
  EXPECT_THAT(faults_of(edited("depth_directory ", "depth_directory a ")),
              HasSubstr("line 3: \"depth_directory\" has 2 fields, not 1"));
  EXPECT_THAT(faults_of(edited("1074.5", "x")), HasSubstr("line 6: field 1: \"x\", not a number"));
  EXPECT_THAT(faults_of(edited("1074.5", "nan")), HasSubstr("\"nan\", not a number"));
  EXPECT_THAT(faults_of(edited("1074.5", "0")), HasSubstr("focal lengths 0 and 1073, not above 0"));
  EXPECT_THAT(faults_of(edited("1074.5 0", "1074.5 2")), HasSubstr("not of the form fx 0 cx 0"));
  EXPECT_THAT(faults_of(edited("a1_d0_0.png ", "")),
              HasSubstr("line 7: \"scan\" has 17 fields, not 18"));
  EXPECT_THAT(faults_of(edited("a1_d0_0.png", "a1.png")),
              HasSubstr("line 7: \"a1.png\", not <viewpoint>_d<cam>_<yaw>.png"));
  EXPECT_THAT(faults_of(edited("1 0 0 2.5", "2 0 0 2.5")), HasSubstr("line 7: the pose of"));
  EXPECT_THAT(faults_of(edited("1 0 0 2.5", "-1 0 0 2.5")), HasSubstr("is no rotation"));
  EXPECT_THAT(faults_of(edited("0 0 0 1", "0 0 .1 1")), HasSubstr("is no rotation"));
}

TEST(UndistortedCameras, NeedTheirIntrinsics) {
  EXPECT_THAT(faults_of(edited("intrinsics_matrix 1074.5 0 629.25  0 1073 509.5  0 0 1", "")),
              AllOf(HasSubstr("line 7: a camera before its intrinsics_matrix"), HasSubstr("line 8"),
                    Not(HasSubstr("line 11"))));
  // Those of the camera before must not pass for those of a file that is not read.
  EXPECT_THAT(faults_of(edited("# the next camera", "intrinsics camera2.txt")), "accepted");
  EXPECT_THAT(
      faults_of(edited("intrinsics_matrix 1075 0 630 0 1076 511 0 0 1", "intrinsics c.txt")),
      HasSubstr("line 11: a camera after `intrinsics <file>`, which is not read"));
}

TEST(UndistortedCameras, KeepMessagesShortOnHostileInput) {
  const std::string faults = faults_of("\x01" + std::string(5000, 'x'));
  EXPECT_THAT(faults, HasSubstr("\"\\x01xxx"));
  EXPECT_LT(faults.size(), 300U);
  std::string lines;
  for (int i = 0; i < 5000; ++i) lines += "?\n";
  EXPECT_THAT(faults_of(lines), HasSubstr("... and 90 more"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
