#include "enfilade/neural/compute_features.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdexcept>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/features/feature_set.h"
#include "tests/support/panoramas.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using tests::refusal;
using tests::TemporaryFolder;

std::shared_ptr<const scan::PanoramaSet> panoramas() {
  return scan::PanoramaSet::of({scan::testing::memory_panoramas("one", 3, 32),
                                scan::testing::memory_panoramas("two", 2, 32)});
}

FeatureJob home_job() {
  FeatureJob job;
  job.encoder.name = "home";
  job.batch = 12;
  return job;
}

std::vector<float> views_of(const features::FeatureSet& set, const char* scan,
                            const char* viewpoint) {
  std::vector<float> views(set.info().views * set.info().dimensions);
  set.copy_views(set.row(scan, viewpoint).value(), views);
  return views;
}

TEST(Features, AreTheEncodersOfEachView) {
  const TemporaryFolder folder("features");
  const fs::path file = folder.path() / "features.safetensors";
  const auto set = panoramas();
  const FeatureReport report = compute_features(set, home_job(), file);
  EXPECT_EQ(report.viewpoints, 5U);
  EXPECT_EQ(report.resumed, 0U);
  EXPECT_TRUE(report.without.empty());
  const features::FeatureSet features = features::FeatureSet::open(file);
  const auto encoder = make_encoder(home_job().encoder);
  EXPECT_EQ(features.info().encoder, "home");
  EXPECT_EQ(features.info().preprocessing, "home");
  EXPECT_EQ(features.info().weights, encoder->weights_hash());
  EXPECT_EQ(features.info().camera, encoder->camera());
  ASSERT_EQ(features.keys().size(), 5U);
  EXPECT_EQ(features.keys()[3], (features::FeatureKey{"two", "v0"}));

  // View 17 of the scan two's second viewpoint, drawn and encoded alone.
  const auto renderer = render::make_renderer(std::make_shared<render::FaceCache>(set));
  const Camera camera = encoder->camera();
  std::vector<float> picture(std::size_t{3} * camera.width * camera.height);
  render::Outputs outputs;
  outputs.colour = {render::ColourFormat::kPlanarFloat32, encoder->normalisation(),
                    std::as_writable_bytes(std::span(picture))};
  constexpr std::size_t kView = 17;
  const auto views = render::discrete_views(ScanIndex(1), ViewpointIndex(1));
  renderer->render(camera, std::span(views).subspan(kView, 1), outputs);
  std::vector<float> alone(encoder->dimensions()), kept(encoder->dimensions());
  encoder->encode(picture, 1, camera, alone);
  features.copy_view(features.row("two", "v1").value(), kView, kept);
  // Another size of batch, another order of sums.
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_NEAR(kept[i], alone[i], 1e-4);
}

TEST(Features, ShardsPutTogetherAreTheWhole) {
  const TemporaryFolder folder("features");
  FeatureJob job = home_job();
  compute_features(panoramas(), job, folder.path() / "whole.safetensors");
  std::vector<fs::path> parts;
  job.shard.count = 2;
  for (job.shard.index = 0; job.shard.index < 2; ++job.shard.index) {
    parts.push_back(folder.path() / (std::to_string(job.shard.index) + ".safetensors"));
    EXPECT_EQ(compute_features(panoramas(), job, parts.back()).viewpoints, 3U - job.shard.index);
  }
  features::convert_features(parts, folder.path() / "merged.safetensors");
  const features::FeatureSet whole =
      features::FeatureSet::open(folder.path() / "whole.safetensors");
  const features::FeatureSet merged =
      features::FeatureSet::open(folder.path() / "merged.safetensors");
  ASSERT_EQ(merged.keys().size(), whole.keys().size());
  for (const features::FeatureKey& key : whole.keys()) {
    EXPECT_EQ(views_of(merged, key.scan.c_str(), key.viewpoint.c_str()),
              views_of(whole, key.scan.c_str(), key.viewpoint.c_str()));
  }
}

TEST(Features, AStoppedRunGoesOn) {
  const TemporaryFolder folder("features");
  const fs::path file = folder.path() / "features.safetensors";
  const auto stop_at_three = [](std::size_t done, std::size_t) {
    if (done == 3) throw std::runtime_error("stopped");
  };
  EXPECT_THROW(compute_features(panoramas(), home_job(), file, stop_at_three), std::runtime_error);
  EXPECT_FALSE(fs::exists(file));
  EXPECT_EQ(compute_features(panoramas(), home_job(), file).resumed, 3U);
  const fs::path whole = folder.path() / "whole.safetensors";
  compute_features(panoramas(), home_job(), whole);
  EXPECT_EQ(read_file(file), read_file(whole));
}

TEST(Features, ExcludedViewpointsHaveNone) {
  const TemporaryFolder folder("features");
  scan::Connectivity graph = scan::testing::row_of_viewpoints("one", 2);
  graph.entries[0].included = false;
  const auto source = std::make_shared<scan::MemoryPanoramas>(
      graph, std::vector{scan::testing::panorama(32, 1), scan::testing::panorama(32, 2)});
  const fs::path file = folder.path() / "features.safetensors";
  EXPECT_EQ(compute_features(scan::PanoramaSet::of({source}), home_job(), file).viewpoints, 1U);
  EXPECT_FALSE(features::FeatureSet::open(file).row("one", "v0").has_value());
}

TEST(Features, RefuseWhatMakesNoSense) {
  const TemporaryFolder folder("features");
  const fs::path file = folder.path() / "features.safetensors";
  FeatureJob job = home_job();
  job.batch = 0;
  EXPECT_THAT(refusal<ArgumentError>([&] { compute_features(panoramas(), job, file); }),
              HasSubstr("batch: 0"));
  job = home_job();
  job.shard = {2, 2};
  EXPECT_THAT(refusal<ArgumentError>([&] { compute_features(panoramas(), job, file); }),
              HasSubstr("shard: 2 of 2"));
  job.shard = {6, 7};  // five viewpoints
  EXPECT_THAT(refusal<ArgumentError>([&] { compute_features(panoramas(), job, file); }),
              HasSubstr("nothing to do"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural
