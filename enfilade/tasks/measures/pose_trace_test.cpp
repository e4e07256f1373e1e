#include "enfilade/tasks/pose_trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/scan/file_tree.h"
#include "enfilade/scan/npy.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::HasSubstr;

using Arrays = std::map<std::string, std::string>;

std::vector<float> count_up(std::size_t n) {
  std::vector<float> values(n);
  for (std::size_t i = 0; i < n; ++i) values[i] = static_cast<float>(i);
  return values;
}

// Three snapshots over two viewpoints, all by hand.
Arrays small_arrays() {
  const std::vector<std::string> panos{"v0", "v0", "v1"};
  return {{"pano", scan::write_npy(panos, {3, 1})},
          {"time", scan::write_npy(std::vector<float>{0, 0.5F, 2}, {3, 1})},
          {"extrinsic_matrix", scan::write_npy(count_up(48), {3, 16})},
          {"intrinsic_matrix", scan::write_npy(count_up(48), {3, 4, 4})}};
}

std::string npz_of(const Arrays& arrays) {
  std::vector<scan::ZipEntry> entries;
  for (const auto& [name, bytes] : arrays) entries.push_back({name + ".npy", bytes});
  return scan::zip(entries);
}

PoseTrace full_trace() {
  PoseTrace trace = parse_pose_trace(npz_of(small_arrays()), "made.npz");
  trace.viewpoints = 2;
  trace.subwords = 3;
  trace.image_mask.assign(2 * kMaskHeight * kMaskWidth, 0);
  trace.image_mask[5] = 1;
  trace.text_mask = {1, 0, 0, 0, 1, 1};
  trace.feature_weights = count_up(2 * kMaskViews);
  for (PoseSnapshot& one : trace.snapshots) one.audio_time = 0.25;
  return trace;
}

TEST(PoseTrace, IsReadFromItsArrays) {
  const PoseTrace trace = parse_pose_trace(npz_of(small_arrays()), "made.npz");
  ASSERT_EQ(trace.snapshots.size(), 3U);
  EXPECT_EQ(trace.snapshots[2].viewpoint, "v1");
  EXPECT_EQ(trace.snapshots[1].time, 0.5);
  EXPECT_FALSE(trace.snapshots[0].audio_time);
  EXPECT_EQ(trace.snapshots[1].extrinsic[3], 19);
  EXPECT_EQ(trace.snapshots[2].intrinsic[15], 47);
  EXPECT_EQ(trace.viewpoints, 0U);
}

TEST(PoseTrace, WhatIsWrittenIsReadBackEqual) {
  const PoseTrace trace = full_trace();
  const std::string bytes = to_npz(trace);
  EXPECT_EQ(parse_pose_trace(bytes, "made.npz"), trace);
  EXPECT_EQ(to_npz(trace), bytes);
  const tests::TemporaryFolder folder("pose_trace");
  const auto file = folder.path() / pose_trace_name(TraceRole::kFollower, 26);
  EXPECT_EQ(file.filename(), "000026_follower_pose_trace.npz");
  write_file_atomically(file, bytes);
  EXPECT_EQ(load_pose_trace(file), trace);
}

// NumPy keeps a transposed array in the order of its memory.
TEST(PoseTrace, ArraysMayBeInFortransOrder) {
  std::string bytes = scan::write_npy(std::vector<float>{1, 2, 3, 4, 5, 6}, {2, 3});
  bytes.replace(bytes.find("False"), 5, "True ");
  const auto array = scan::NpyArray::parse(bytes);
  // Columns one after another: (1, 2), (3, 4), (5, 6).
  EXPECT_EQ(array.number(0), 1);
  EXPECT_EQ(array.number(1), 3);
  EXPECT_EQ(array.number(3), 2);
}

TEST(PoseTrace, OtherTypesOfNumbersAreRead) {
  const auto array = [](const std::string& type, const std::string& data) {
    std::string bytes = scan::write_npy(std::vector<float>{}, {0});
    const auto replace = [&bytes](const std::string& from, const std::string& to) {
      bytes.replace(bytes.find(from), from.size(), to);
    };
    replace("<f4", type);
    replace("(0,)", "(1,)");
    return scan::NpyArray::parse(bytes + data).number(0);
  };
  EXPECT_EQ(array("<f8", std::string("\0\0\0\0\0\0\xf8\x3f", 8)), 1.5);
  EXPECT_EQ(array(">f4", std::string("\x3f\xc0\0\0", 4)), 1.5);
  EXPECT_EQ(array("<f2", std::string("\0\x3e", 2)), 1.5);
  EXPECT_EQ(array("<i2", std::string("\xfe\xff", 2)), -2);
  EXPECT_EQ(array("|u1", "\xfe"), 254);
  EXPECT_EQ(array("|b1", "\x02"), 1);
}

TEST(PoseTrace, TextsOfNumPyBecomeUtf8) {
  const std::vector<std::string> texts{"", "\xE0\xA4\x86x", "\xF0\x9F\x98\x80"};
  const auto array = scan::NpyArray::parse(scan::write_npy(texts, {3}));
  for (std::size_t i = 0; i < texts.size(); ++i) EXPECT_EQ(array.text(i), texts[i]);
  EXPECT_THROW(scan::write_npy(std::vector<std::string>{"\xff"}, {1}), ArgumentError);
}

struct Refusal {
  const char* says;
  std::function<void(Arrays&)> damage;
};

TEST(PoseTrace, RefusesWhatIsDamaged) {
  const auto floats = [](const std::vector<float>& values, const std::vector<std::size_t>& shape) {
    return scan::write_npy(values, shape);
  };
  const std::vector<Refusal> refusals{
      {"$: has no array \"pano\"", [](Arrays& a) { a.erase("pano"); }},
      {"$: has no array \"extrinsic_matrix\"", [](Arrays& a) { a.erase("extrinsic_matrix"); }},
      {"$.time: shape (2, 2), not (n, 1)",
       [&](Arrays& a) {
         a["time"] = floats({0, 1, 2, 3}, {2, 2});
       }},
      {"$.time: 2 snapshots, where the arrays before have 3",
       [&](Arrays& a) {
         a["time"] = floats({0, 1}, {2});
       }},
      {"$.time[2]: 0.5 s, after 1 s",
       [&](Arrays& a) {
         a["time"] = floats({0, 1, 0.5F}, {3});
       }},
      {"$.time[1]: nan, not a finite number",
       [&](Arrays& a) {
         a["time"] = floats({0, std::numeric_limits<float>::quiet_NaN(), 1}, {3});
       }},
      {"$.time[1]: -1 s, after 0 s",
       [&](Arrays& a) {
         a["time"] = floats({std::numeric_limits<float>::quiet_NaN(), -1, 1}, {3});
       }},
      {"$.audio_time[0]: inf, not a finite number",
       [&](Arrays& a) {
         a["audio_time"] = floats({std::numeric_limits<float>::infinity(), 1, 1}, {3});
       }},
      {"$.pano: elements of type \"<f4\", not texts",
       [&](Arrays& a) {
         a["pano"] = floats({1, 2, 3}, {3, 1});
       }},
      {"$.pano[1]: an empty id",
       [](Arrays& a) {
         a["pano"] = scan::write_npy(std::vector<std::string>{"v0", "", "v1"}, {3, 1});
       }},
      {"$.time: elements of type \"<U2\", not numbers", [](Arrays& a) { a["time"] = a["pano"]; }},
      {"$.extrinsic_matrix: shape (3, 12), not (n, 16)",
       [&](Arrays& a) {
         a["extrinsic_matrix"] = floats(count_up(36), {3, 12});
       }},
      {"$.intrinsic_matrix: shape (48,), not (n, 16)",
       [&](Arrays& a) { a["intrinsic_matrix"] = floats(count_up(48), {48}); }},
      {"$.image_mask: shape (1, 4), not (k, 128, 256)",
       [&](Arrays& a) {
         a["image_mask"] = floats({0, 1, 0, 1}, {1, 4});
       }},
      // 2^60 rows of nothing: times 16 that is 0 again.
      {"$.extrinsic_matrix: shape (1152921504606846976, 0), not (n, 16)",
       [](Arrays& a) {
         a.erase("pano");
         a.erase("time");
         std::string empty = scan::write_npy(std::vector<float>{}, {0, 0});
         const auto at = empty.find("(0, 0), }");
         empty.replace(at, 27, "(1152921504606846976, 0), }");
         a["extrinsic_matrix"] = empty;
       }},
      {"$.time: 1048577 snapshots; 1048576 at most are read",
       [&](Arrays& a) {
         a.erase("pano");
         a["time"] = floats(count_up(1048577), {1048577});
       }},
      {"$.text_mask: shape (2, 0), not (k, m)",
       [&](Arrays& a) {
         a["text_mask"] = floats({}, {2, 0});
       }},
      {"$.feature_weights: shape (36,), not (k, 36)",
       [&](Arrays& a) { a["feature_weights"] = floats(count_up(36), {36}); }},
      {"$.text_mask: 2 viewpoints, where the arrays before have 1",
       [&](Arrays& a) {
         a["feature_weights"] = floats(count_up(36), {1, 36});
         a["text_mask"] = floats({0, 1}, {2, 1});
       }},
      {"$.time: no array of NumPy's", [](Arrays& a) { a["time"] = "text"; }},
      {"$.time: 8 bytes of elements, not the 12",
       [](Arrays& a) { a["time"].resize(a["time"].size() - 4); }},
      {"elements of type \"|O8\"",
       [](Arrays& a) { a["time"].replace(a["time"].find("<f4"), 3, "|O8"); }},
      {"$.time: version 9", [](Arrays& a) { a["time"][6] = '\x09'; }},
      {"which is too large",
       [](Arrays& a) {
         const auto at = a["time"].find("(3, 1), }");
         a["time"].replace(at, 26, "(9999999999,9999999999), }");
       }},
  };
  for (const Refusal& one : refusals) {
    Arrays arrays = small_arrays();
    one.damage(arrays);
    EXPECT_THAT(tests::refusal([&] { parse_pose_trace(npz_of(arrays), "made.npz"); }),
                HasSubstr(one.says));
  }
  EXPECT_THAT(tests::refusal([] { parse_pose_trace("no zip", "made.npz"); }),
              HasSubstr("no zip file"));
}

TEST(PoseTrace, AllFaultsAreInOneList) {
  Arrays arrays = small_arrays();
  arrays.erase("pano");
  arrays["time"] = scan::write_npy(std::vector<float>{3, 2, 1}, {3});
  arrays["intrinsic_matrix"] = "";
  try {
    parse_pose_trace(npz_of(arrays), "made.npz");
    FAIL();
  } catch (const InvalidInput& refused) {
    EXPECT_EQ(refused.diagnostics().size(), 4U);
  }
}

TEST(PoseTrace, TheFirstTimeMayBeNoNumber) {
  Arrays arrays = small_arrays();
  arrays["time"] =
      scan::write_npy(std::vector<float>{std::numeric_limits<float>::quiet_NaN(), 1, 2}, {3});
  EXPECT_EQ(parse_pose_trace(npz_of(arrays), "made.npz").snapshots[0].time, 0);
}

TEST(PoseTrace, WhatIsNotReadIsNotWritten) {
  PoseTrace trace = full_trace();
  trace.snapshots[1].audio_time.reset();
  EXPECT_THROW(to_npz(trace), ArgumentError);
  trace = full_trace();
  trace.feature_weights.pop_back();
  EXPECT_THROW(to_npz(trace), ArgumentError);
  trace = full_trace();
  trace.snapshots[2].time = -1;
  EXPECT_THROW(to_npz(trace), ArgumentError);
  EXPECT_THROW(to_npz(PoseTrace()), ArgumentError);
}

TEST(PoseTrace, LooksGoThroughTheMatrices) {
  for (const double heading : {0.0, 0.3, 2.0, 4.0, 6.2}) {
    for (const double elevation : {-1.0, 0.0, 0.5}) {
      const CameraLook look{{1, -2, 3.5}, Radians(heading), Radians(elevation), Radians(1), 1.5};
      const CameraLook back = look_of(snapshot_of("v", 1, look));
      EXPECT_NEAR(back.heading.value, heading, 1e-6);  // floats
      EXPECT_NEAR(back.elevation.value, elevation, 1e-6);
      EXPECT_NEAR(back.view_angle.value, 1, 1e-6);
      EXPECT_NEAR(back.aspect, 1.5, 1e-6);
      EXPECT_EQ(back.position, look.position);
    }
  }
}

// By hand: a camera that looks along our +y (heading 0) looks along -z where y is up, so its frame
// is that world's.
TEST(PoseTrace, HeadingZeroIsTheIdentity) {
  const PoseSnapshot snapshot = snapshot_of("v", 0, {{0, 0, 0}, {}, {}, Radians(kPi / 2), 1});
  for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(snapshot.extrinsic[i], i % 5 == 0 ? 1 : 0) << i;
  EXPECT_NEAR(snapshot.intrinsic[0], 1, 1e-6);  // tan 45 degrees
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
