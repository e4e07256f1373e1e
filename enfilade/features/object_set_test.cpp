#include "enfilade/features/object_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <optional>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/features/hdf5_writer.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::features {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using tests::refusal;

class ObjectSetTest : public ::testing::Test {
 protected:
  // Two objects of three numbers.
  Hdf5Dataset dataset(const std::string& name) const {
    Hdf5Dataset made;
    made.name = name;
    made.array = {Hdf5Type::kFloat32, {2, 3}, std::as_bytes(std::span(numbers_))};
    made.attributes = {
        {"obj_ids", ids_},
        {"directions", Hdf5Array{Hdf5Type::kFloat64, {2, 2}, std::as_bytes(std::span(angles_))}},
        {"sizes", Hdf5Array{Hdf5Type::kInt64, {2, 2}, std::as_bytes(std::span(sizes_))}}};
    return made;
  }
  ObjectSet written(const std::vector<Hdf5Dataset>& datasets) const {
    Hdf5Writer writer(file());
    for (const Hdf5Dataset& one : datasets) writer.write(one);
    writer.finish();
    return ObjectSet::open(file());
  }
  std::string refused(const Hdf5Dataset& one) const {
    return refusal<InvalidInput>([&] { written({one}); });
  }
  std::filesystem::path file() const { return folder_.path() / "o.hdf5"; }

  tests::TemporaryFolder folder_{"objects"};
  std::array<float, 6> numbers_{1, 2, 3, 4, 5, 6};
  std::array<double, 4> angles_{0.5, -0.25, 3, 0.125};
  std::array<std::int64_t, 4> sizes_{100, 50, 30, 20};
  std::array<double, 8> boxes_{0, 0, 300, 150, 60, 60, 120, 180};
  std::vector<std::string> ids_{"67", "4"};
};

TEST_F(ObjectSetTest, ObjectsAreReadInTheFilesOrder) {
  Hdf5Dataset soon = dataset("a_b_w");
  soon.attributes.pop_back();
  soon.attributes.push_back(
      {"bboxes", Hdf5Array{Hdf5Type::kFloat64, {2, 4}, std::as_bytes(std::span(boxes_))}});
  const ObjectSet set = written({dataset("a_v"), soon});
  EXPECT_EQ(set.dimensions(), 3U);
  const auto objects = set.objects("a", "v");
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_EQ(objects[0].id, "67");
  EXPECT_EQ(objects[0].heading.value, 0.5);
  EXPECT_EQ(objects[1].elevation.value, 0.125);
  EXPECT_EQ(objects[0].width, 100);
  EXPECT_EQ(objects[1].height, 20);
  std::array<float, 3> read{};
  set.copy("a", "v", 1, read);
  EXPECT_THAT(read, ElementsAre(4, 5, 6));
  std::array<float, 2> first{};
  set.copy("a_b", "w", 0, first);
  EXPECT_THAT(first, ElementsAre(1, 2)) << "the first columns alone";
  EXPECT_DOUBLE_EQ(set.objects("a_b", "w")[0].width, 320) << "half of a picture";
  EXPECT_DOUBLE_EQ(set.objects("a_b", "w")[1].height, 96);
  EXPECT_TRUE(set.objects("a", "nowhere").empty());
}

TEST_F(ObjectSetTest, ViewpointsMayHaveUnderscores) {
  const ObjectSet set = written({dataset("a_v_1")});
  EXPECT_EQ(set.objects("a", "v_1").size(), 2U);
  EXPECT_TRUE(set.objects("a", "v").empty());
}

TEST_F(ObjectSetTest, WhatIsWrongIsNamedWithItsViewpoint) {
  Hdf5Dataset one = dataset("a_v");
  one.attributes.erase(one.attributes.begin());
  EXPECT_THAT(refused(one), AllOf(HasSubstr("\"a_v\""), HasSubstr("no attribute \"obj_ids\"")));
  one = dataset("a_v");
  one.attributes[0].value = std::vector<std::string>{"67"};
  EXPECT_THAT(refused(one), HasSubstr("attribute \"obj_ids\" of 1 elements, not 2"));
  one = dataset("a_v");
  one.attributes[1].value = std::vector<std::string>{"a", "b", "c", "d"};
  EXPECT_THAT(refused(one), HasSubstr("attribute \"directions\": not numbers"));
  one = dataset("name");
  EXPECT_THAT(refused(one), HasSubstr("name"));
  numbers_[2] = std::numeric_limits<float>::infinity();
  const ObjectSet odd = written({dataset("a_v")});
  std::array<float, 3> read{};
  odd.copy("a", "v", 1, read);
  EXPECT_THAT(read, ElementsAre(4, 5, 6)) << "the other object is of use";
  EXPECT_THAT(refusal<InvalidInput>([&] { odd.copy("a", "v", 0, read); }),
              AllOf(HasSubstr("\"a_v\""), HasSubstr("infinite or NaN")));
  write_file_atomically(file(), "no HDF5");
  EXPECT_THAT(refusal([&] { ObjectSet::open(file()); }), HasSubstr("not an HDF5 file"));
  EXPECT_THAT(refusal([&] { ObjectSet::open(folder_.path() / "none.hdf5"); }),
              HasSubstr("none.hdf5: cannot be read"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::features
