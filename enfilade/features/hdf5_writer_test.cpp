#include "enfilade/features/hdf5_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/features/feature_set.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::features {
namespace EN_UNIT {

using ::testing::HasSubstr;

// 36 views of two numbers: what the reader of features takes.
struct Views {
  std::array<float, 72> numbers{};
  Hdf5Dataset dataset;

  explicit Views(const std::string& name, float first) {
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = first + static_cast<float>(i);
    dataset.name = name;
    dataset.array = {Hdf5Type::kFloat32, {36, 2}, std::as_bytes(std::span(numbers))};
  }
};

class Hdf5WriterTest : public ::testing::Test {
 protected:
  std::filesystem::path file(const std::string& name) const { return folder_.path() / name; }
  tests::TemporaryFolder folder_{"hdf5_writer"};
};

TEST_F(Hdf5WriterTest, WhatItWritesIsRead) {
  Views a("s_a", 0);
  const Views b("s_b", 100);
  const std::array<std::int64_t, 2> sizes{1, 2};
  a.dataset.attributes = {
      {"scanId", std::string("s")},
      {"image_w", std::int64_t{320}},
      {"vfov", 45.5},
      {"obj_ids", std::vector<std::string>{"1", "2"}},
      {"sizes", Hdf5Array{Hdf5Type::kInt64, {2}, std::as_bytes(std::span(sizes))}}};
  Hdf5Writer writer(file("f.hdf5"));
  writer.write(b.dataset);
  EXPECT_FALSE(file_exists(file("f.hdf5")));
  Hdf5Dataset same = a.dataset;
  same.attributes.clear();
  writer.write(same);
  writer.finish();
  const FeatureSet set = FeatureSet::open(file("f.hdf5"));
  ASSERT_EQ(set.keys().size(), 2U);
  std::array<float, 72> read{};
  set.copy_views(set.row("s", "b").value(), read);
  EXPECT_EQ(read, b.numbers);

  Hdf5Writer attributes(file("g.hdf5"), {.gzip = 0});
  attributes.write(a.dataset);
  attributes.finish();
  const FeatureInfo info = FeatureSet::open(file("g.hdf5")).info();
  EXPECT_EQ(info.camera.width, 320U);
  EXPECT_NEAR(to_degrees(info.camera.vertical_field_of_view), 45.5, 1e-9);
}

TEST_F(Hdf5WriterTest, PartsOfAFileAreCopied) {
  const Views a("s_a", 0);
  const Views b("s_b", 100);
  for (const Views* one : {&a, &b}) {
    Hdf5Writer part(file(one->dataset.name));
    part.write(one->dataset);
    part.finish();
  }
  Hdf5Writer whole(file("f.hdf5"));
  whole.copy_from(file("s_a"));
  whole.copy_from(file("s_b"));
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { whole.copy_from(file("s_a")); }),
              HasSubstr("\"s_a\" is there already"));
  EXPECT_THROW(whole.copy_from(file("none")), FileError);
  whole.finish();
  EXPECT_EQ(FeatureSet::open(file("f.hdf5")).keys().size(), 2U);
}

TEST_F(Hdf5WriterTest, RefusesWhatTheFormatCannotHold) {
  Hdf5Writer writer(file("f.hdf5"));
  Views a("s_a", 0);
  writer.write(a.dataset);
  EXPECT_THROW(writer.write(a.dataset), ArgumentError);
  const auto refused = [&](auto&& change) {
    Views other("s_b", 0);
    change(other.dataset);
    EXPECT_THROW(writer.write(other.dataset), ArgumentError);
  };
  refused([](Hdf5Dataset& d) { d.name = "a/b"; });
  refused([](Hdf5Dataset& d) { d.name = ""; });
  refused([](Hdf5Dataset& d) { d.array.shape = {36, 3}; });
  refused([](Hdf5Dataset& d) { d.array.shape = {}; });
  refused([](Hdf5Dataset& d) { d.array.shape = {0, 72}; });
  refused([](Hdf5Dataset& d) { d.array.shape = {~std::uint64_t{0}, 2}; });
  refused([](Hdf5Dataset& d) { d.attributes = {{"a", std::string("a\0b", 3)}}; });
  refused([](Hdf5Dataset& d) { d.attributes = {{"a", std::vector<std::string>{}}}; });
  EXPECT_THROW(Hdf5Writer(file("g.hdf5"), {.gzip = 10}), ArgumentError);
  EXPECT_THROW(Hdf5Writer(file("none") / "g.hdf5"), FileError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::features
