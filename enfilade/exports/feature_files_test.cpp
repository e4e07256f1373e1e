#include "enfilade/exports/feature_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/exports/detail/scan_parts.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/tasks/objects.h"
#include "tests/support/graphs.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::exports {
namespace EN_UNIT {

using features::Hdf5Type;
using ::testing::HasSubstr;

constexpr std::size_t kColumns = 2;

std::shared_ptr<const graph::GraphSet> pair_of_viewpoints() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::connectivity("s", {{0, 0, 0}, {1, 0, 0}}, {{0, 1}}));
  return graph::GraphSet::of(std::move(graphs));
}

class FeatureFiles : public ::testing::Test {
 protected:
  FeatureFiles() : folder_("feature_files") {}
  std::filesystem::path file(const std::string& name) const { return folder_.path() / name; }

  // Of view k of viewpoint v: k + 100 v, and the same negative.
  std::filesystem::path write_features(const std::string& name, std::size_t viewpoints,
                                       std::size_t columns = kColumns) const {
    std::vector<features::FeatureKey> keys;
    for (std::size_t v = 0; v < viewpoints; ++v) keys.push_back({"s", "v" + std::to_string(v)});
    features::FeatureInfo info;
    info.dimensions = columns;
    auto writer = features::FeatureWriter::create(file(name), info, keys);
    for (std::size_t v = 0; v < viewpoints; ++v) {
      std::vector<float> numbers;
      for (std::size_t i = 0; i < 36 * columns; ++i) {
        const auto value = static_cast<float>(i / columns + 100 * v);
        numbers.push_back(i % columns == 0 ? value : -value);
      }
      writer.write(v, numbers);
    }
    writer.finish();
    return file(name);
  }

  tests::TemporaryFolder folder_;
};

TEST_F(FeatureFiles, ViewsHaveFeaturesThenClasses) {
  const auto graphs = pair_of_viewpoints();
  const FeatureSource source{write_features("f.safetensors", 2),
                             write_features("l.safetensors", 2, 1), Hdf5Type::kFloat64};
  std::vector<std::size_t> steps;
  write_view_features(graphs, source, file("out.hdf5"),
                      {.progress = [&](std::size_t done, std::size_t) { steps.push_back(done); }});
  EXPECT_EQ(steps.back(), 2U);
  EXPECT_FALSE(file_exists(file("out.hdf5.parts")));
  const features::FeatureSet out = features::FeatureSet::open(file("out.hdf5"));
  EXPECT_EQ(out.info().dimensions, 3U);
  EXPECT_EQ(out.info().camera, Camera());
  std::array<float, 3> view{};
  out.copy_view(out.row("s", "v1").value(), 5, view);
  EXPECT_THAT(view, ::testing::ElementsAre(105, -105, 105));
}

TEST_F(FeatureFiles, ViewpointsWithoutFeaturesAreNamed) {
  const FeatureSource source{write_features("f.safetensors", 1)};
  EXPECT_THAT(tests::refusal<LookupError>(
                  [&] { write_view_features(pair_of_viewpoints(), source, file("o.hdf5")); }),
              HasSubstr("1 of 2 viewpoints are not in it, the first: s_v1"));
  EXPECT_THROW(write_view_features(pair_of_viewpoints(), {source.features, {}, Hdf5Type::kInt64},
                                   file("o.hdf5")),
               ArgumentError);
}

TEST_F(FeatureFiles, WhatWasStoppedGoesOn) {
  const auto graphs = pair_of_viewpoints();
  const FeatureSource source{write_features("f.safetensors", 2)};
  struct Stop {};
  const auto stop = [](std::size_t done, std::size_t total) {
    if (done == total) throw Stop();
  };
  EXPECT_THROW(write_view_features(graphs, source, file("o.hdf5"), {.progress = stop}), Stop);
  EXPECT_FALSE(file_exists(file("o.hdf5")));
  EXPECT_TRUE(file_exists(file("o.hdf5.parts") / "job.txt"));
  write_view_features(graphs, source, file("o.hdf5"));
  EXPECT_EQ(features::FeatureSet::open(file("o.hdf5")).keys().size(), 2U);
  EXPECT_FALSE(file_exists(file("o.hdf5.parts")));
}

// Scans s, with two viewpoints or one, and t with one.
std::shared_ptr<const graph::GraphSet> two_scans(bool whole) {
  scan::Connectivity s = graph::testing::connectivity("s", {{0, 0, 0}, {1, 0, 0}}, {{0, 1}});
  s.entries[1].included = whole;
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(s);
  graphs.emplace_back(graph::testing::connectivity("t", {{0, 0, 0}}, {}));
  return graph::GraphSet::of(std::move(graphs));
}

TEST_F(FeatureFiles, FinishedScansAreKeptForTheSameViewpointsOnly) {
  const std::vector<features::FeatureKey> keys{{"s", "v0"}, {"s", "v1"}, {"t", "v0"}};
  features::FeatureInfo info;
  info.dimensions = kColumns;
  auto writer = features::FeatureWriter::create(file("f.safetensors"), info, keys);
  const std::vector<float> numbers(36 * kColumns);
  for (std::size_t k = 0; k < keys.size(); ++k) writer.write(k, numbers);
  writer.finish();
  const FeatureSource source{file("f.safetensors")};
  for (const bool same : {true, false}) {
    struct Stop {};
    const auto stop = [](std::size_t done, std::size_t total) {
      if (done == total) throw Stop();
    };
    EXPECT_THROW(write_view_features(two_scans(true), source, file("o.hdf5"), {.progress = stop}),
                 Stop);
    EXPECT_TRUE(file_exists(file("o.hdf5.parts") / "s.hdf5"));
    EXPECT_FALSE(file_exists(file("o.hdf5.parts") / "t.hdf5"));
    std::vector<std::size_t> steps;
    const auto count = [&](std::size_t done, std::size_t) { steps.push_back(done); };
    write_view_features(two_scans(same), source, file("o.hdf5"), {.progress = count});
    ASSERT_FALSE(steps.empty());
    EXPECT_EQ(steps[0], same ? 3U : 1U) << "the first viewpoint that is written";
    EXPECT_EQ(features::FeatureSet::open(file("o.hdf5")).keys().size(), same ? 3U : 2U);
  }
}

TEST_F(FeatureFiles, AViewpointThatSeesNoObjectIsNotThere) {
  tasks::ObjectBoxes boxes;
  boxes.add("s", "v0", {{7, "chair", {}, {}}});
  boxes.add("s", "v1",
            {{8, "table", {12, 13}, {{0, 0, 10, 10}, {0, 0, 20, 20}}}, {9, "lamp", {}, {}}});
  const FeatureSource source{write_features("f.safetensors", 2)};
  write_object_features(pair_of_viewpoints(), boxes, source, file("o.hdf5"));
  // The reader of views reads it, as there is one dataset: one object, whose numbers are the mean
  // of views 12 and 13 of v1.
  const features::FeatureSet out = features::FeatureSet::open(file("o.hdf5"));
  ASSERT_EQ(out.keys().size(), 1U);
  EXPECT_EQ(out.keys()[0].viewpoint, "v1");
  EXPECT_EQ(out.info().views, 1U);
  std::array<float, kColumns> object{};
  out.copy_view(0, 0, object);
  EXPECT_THAT(object, ::testing::ElementsAre(112.5F, -112.5F));
}

TEST_F(FeatureFiles, TokensOfOtherShapesAreRefused) {
  const std::vector<float> numbers(12 * 195 * 2);
  const std::array<features::NamedArray, 2> arrays{
      {{"s_v0", features::DType::kFloat32, {12, 195, 2}, std::as_bytes(std::span(numbers))},
       {"s_v1", features::DType::kFloat32, {12, 195, 2}, std::as_bytes(std::span(numbers))}}};
  features::write_safetensors(file("t.safetensors"), arrays);
  EXPECT_THAT(tests::refusal<InvalidInput>([&] {
                write_tokens(pair_of_viewpoints(), file("t.safetensors"), bevbert_tokens(),
                             file("o.hdf5"));
              }),
              HasSubstr("shape 12 195 2; 12 views of 196 tokens are wanted"));
}

TEST_F(FeatureFiles, NumbersTooLargeForSixteenBitsAreNamed) {
  features::FeatureInfo info;
  info.dimensions = 1;
  auto writer =
      features::FeatureWriter::create(file("l.safetensors"), info, {{"s", "v0"}, {"s", "v1"}});
  const std::vector<float> numbers(36, 70000);
  for (const std::size_t row : {0U, 1U}) writer.write(row, numbers);
  writer.finish();
  EXPECT_THAT(tests::refusal<ArgumentError>([&] {
                write_view_features(pair_of_viewpoints(),
                                    {file("l.safetensors"), {}, Hdf5Type::kFloat16},
                                    file("o.hdf5"));
              }),
              HasSubstr("s_v0: 70000 is no number of 16 bits"));
}

TEST(PoolDepth, IsTheMeanOfReadings) {
  // One picture of 2 x 2 cells of 2 x 2 pixels.
  const std::vector<float> depths{1, 0, 20, 20,  //
                                  3, 0, 5,  0,   //
                                  0, 0, 2,  2,   //
                                  0, 0, 2,  6};
  std::array<float, 4> cells{};
  detail::pool_depth(depths, 1, 2, 2, 10, cells);
  EXPECT_THAT(cells, ::testing::ElementsAre(0.2F, ::testing::FloatNear(2.5F / 3, 1e-6F), 0,
                                            ::testing::FloatNear(0.3F, 1e-6F)));
}

}  // namespace EN_UNIT
}  // namespace enfilade::exports
