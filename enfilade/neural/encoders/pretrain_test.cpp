#include "enfilade/neural/pretrain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/neural/encoder.h"
#include "enfilade/neural/encoders/home_network.h"
#include "tests/support/patchworks.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural {
namespace EN_UNIT {

using ::testing::HasSubstr;
using tests::patchwork;
using tests::patchworks;
using tests::refusal;
using tests::TemporaryFolder;

PretrainConfig small_config() {
  PretrainConfig config;
  config.training = {"known"};
  config.unseen = {"other"};
  config.pictures = 300;
  config.epochs = 4;
  config.room = [](const std::string&, const std::string& viewpoint) {
    return viewpoint == "v0" ? 'k' : 'b';
  };
  return config;
}

std::shared_ptr<const scan::PanoramaSet> both() {
  return scan::PanoramaSet::of({patchworks("known", 20, 100), patchworks("other", 6, 500)});
}

TEST(Pretrain, LearnsWhatIsWhere) {
  const TemporaryFolder folder("pretrain");
  const auto file = folder.path() / "home.safetensors";
  std::size_t steps = 0;
  const PretrainReport report = pretrain_home_encoder(
      both(), small_config(), file, [&](std::size_t step, std::size_t, double) { steps = step; });
  EXPECT_EQ(report.classes, (std::vector<std::int64_t>{0, 1, 3, 11, 14}));
  EXPECT_EQ(report.rooms, "bk");
  EXPECT_EQ(report.steps, steps);
  // Pure colours: nearly all of it is learnt in a few dozen steps, in places never seen too.
  EXPECT_GT(report.unseen.mean_average_precision, 0.9);
  EXPECT_GT(report.unseen.mean_average_precision, report.unseen.chance + 0.2);
  EXPECT_LT(report.unseen.distance_error, 0.3);  // ln 2 = 0.69 lies between the two distances
  const auto encoder = make_encoder({.name = "home", .weights = file});
  EXPECT_EQ(encoder->dimensions(), 3U * (5 + 1) + 2);
}

TEST(Pretrain, TheSameSeedGivesTheSameBytes) {
  const TemporaryFolder folder("pretrain");
  PretrainConfig config = small_config();
  config.pictures = 64;
  config.epochs = 1;
  const auto bytes = [&](std::uint64_t seed, int threads) {
    config.seed = seed;
    config.threads = threads;
    pretrain_home_encoder(both(), config, folder.path() / "home.safetensors");
    return read_file(folder.path() / "home.safetensors");
  };
  const std::string first = bytes(1, 1);
  EXPECT_EQ(bytes(1, 2), first);
  EXPECT_NE(bytes(2, 1), first);
}

TEST(Pretrain, RefusesWhatItCannotLearnFrom) {
  const TemporaryFolder folder("pretrain");
  const auto file = folder.path() / "home.safetensors";
  const auto refused = [&](const PretrainConfig& config) {
    return refusal([&] { pretrain_home_encoder(both(), config, file); });
  };
  PretrainConfig config = small_config();
  config.training.clear();
  EXPECT_THAT(refused(config), HasSubstr("training: no scan"));
  config = small_config();
  config.epochs = 0;
  EXPECT_THAT(refused(config), HasSubstr("epochs: 0"));
  config = small_config();
  config.training = {"nowhere"};
  EXPECT_THAT(refused(config), HasSubstr("nowhere"));

  scan::Panorama colour_only = patchwork(1);
  colour_only.classes = {};
  const auto set = scan::PanoramaSet::of({std::make_shared<scan::MemoryPanoramas>(
      scan::testing::row_of_viewpoints("known", 1), std::vector{colour_only})});
  config = small_config();
  config.unseen.clear();
  EXPECT_THAT(refusal<LookupError>([&] { pretrain_home_encoder(set, config, file); }),
              HasSubstr("class"));
}

TEST(Pretrain, AnEncodersFileIsNoOtherOne) {
  const TemporaryFolder folder("pretrain");
  const auto file = folder.path() / "other.safetensors";
  const std::vector<float> values(3);
  features::write_safetensors(
      file, std::vector<features::NamedArray>{
                {"a", features::DType::kFloat32, {3}, std::as_bytes(std::span(values))}});
  EXPECT_THAT(refusal<InvalidInput>([&] { make_encoder({.name = "home", .weights = file}); }),
              HasSubstr("enfilade pretrain"));
}

TEST(AveragePrecision, IsWorkedOutByHand) {
  const std::vector<float> scores{0.9F, 0.8F, 0.7F, 0.6F};
  const auto precision = [&](std::vector<std::uint8_t> truths) {
    return encoders::average_precision(scores, truths);
  };
  EXPECT_DOUBLE_EQ(precision({1, 1, 0, 0}), 1);
  EXPECT_DOUBLE_EQ(precision({0, 1, 0, 1}), (1 / 2.0 + 2 / 4.0) / 2);
  EXPECT_DOUBLE_EQ(precision({0, 0, 0, 1}), 0.25);
  EXPECT_TRUE(std::isnan(precision({0, 0, 0, 0})));
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural
