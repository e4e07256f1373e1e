#include "enfilade/neural/pretrain.h"

#include <ATen/ATen.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/neural/encoders/home_network.h"
#include "enfilade/neural/encoders/home_pictures.h"
#include "tests/support/patchworks.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural {
namespace EN_UNIT {

using ::testing::HasSubstr;
using tests::patchworks;
using tests::refusal;
using tests::TemporaryFolder;

constexpr std::size_t kKnown = 20, kOther = 8;  // viewpoints

char room_of(const std::string&, const std::string& viewpoint) {
  return viewpoint.back() % 2 == 0 ? 'k' : 'b';
}

ProbeConfig both_scans() {
  return {.training = {"known"}, .unseen = {"other"}, .room = room_of, .threads = 1};
}

std::shared_ptr<const scan::PanoramaSet> panoramas() {
  return scan::PanoramaSet::of(
      {patchworks("known", kKnown, 100), patchworks("other", kOther, 500)});
}

// A feature file for all viewpoints, with the rows that `rows_of` gives for the labels of a
// viewpoint's views: (36, dimensions).
template <class RowsOf>
features::FeatureSet features_of(const std::shared_ptr<const scan::PanoramaSet>& set,
                                 const std::filesystem::path& file, RowsOf rows_of,
                                 std::size_t left_out = 0) {
  std::vector<features::FeatureKey> keys;
  std::vector<at::Tensor> rows;
  for (const std::string& scan : std::vector<std::string>{"known", "other"}) {
    for (const auto& place : encoders::places_of(*set, {&scan, 1}, room_of)) {
      const auto labels = encoders::label_views(set, {&place, 1}, degrees(60), 1);
      rows.push_back(rows_of(labels).to(at::kFloat).contiguous());
      keys.push_back({scan, set->source(place.scan).poses()[place.viewpoint.at()].viewpoint});
    }
  }
  keys.resize(keys.size() - left_out);
  const auto dimensions = static_cast<std::size_t>(rows[0].size(1));
  features::FeatureInfo info;
  info.encoder = "made-up";
  info.dimensions = dimensions;
  info.camera = {640, 480, degrees(60)};
  auto writer = features::FeatureWriter::create(file, info, keys);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    writer.write(i, {rows[i].data_ptr<float>(), static_cast<std::size_t>(rows[i].numel())});
  }
  writer.finish();
  return features::FeatureSet::open(file);
}

// What an encoder would say that missed nothing: whether classes are shown, distances, the room.
at::Tensor truth(const encoders::LabelledPictures& labels) {
  const at::Tensor shares = labels.classes.to(at::kFloat) / 64;
  return at::cat(
      {shares.mean({2, 3}).gt(0.02), encoders::pool_thirds(shares).gt(0.02).flatten(1),
       encoders::pool_thirds(labels.distances).flatten(1), labels.rooms.eq('k').unsqueeze(1)},
      1);
}

TEST(Probe, ReadsAllFromFeaturesThatHoldIt) {
  const TemporaryFolder folder("probe");
  const auto set = panoramas();
  const auto features = features_of(set, folder.path() / "truth.safetensors", truth);
  const ProbeReport report = probe_features(features, set, both_scans());
  EXPECT_EQ(report.training, kKnown);
  EXPECT_EQ(report.unseen, kOther);
  EXPECT_EQ(report.dimensions, 4U * 42 + 3 + 1);
  EXPECT_EQ(report.classes, 4U);
  EXPECT_GT(report.view_precision, 0.99);
  EXPECT_LT(report.view_chance, 0.95);
  EXPECT_GT(report.third_precision, 0.99);
  EXPECT_LT(report.third_chance, 0.8);
  EXPECT_EQ(report.room, 1);
  EXPECT_EQ(report.viewpoint_room, 1);
  EXPECT_EQ(report.room_chance, 0.5);
  EXPECT_LT(report.distance_error, 0.01);
  EXPECT_GT(report.distance_chance, 0.1);
}

TEST(Probe, ReadsNothingFromNoise) {
  const TemporaryFolder folder("probe");
  const auto set = panoramas();
  std::int64_t place = 0;
  const auto noise = [&](const encoders::LabelledPictures&) {
    Rng rng(7, static_cast<std::uint64_t>(place++));
    at::Tensor rows = at::empty({36, 20});
    for (std::int64_t i = 0; i < rows.numel(); ++i) {
      rows.data_ptr<float>()[i] = static_cast<float>(rng.uniform());
    }
    return rows;
  };
  const auto features = features_of(set, folder.path() / "noise.safetensors", noise);
  const ProbeReport report = probe_features(features, set, both_scans());
  EXPECT_NEAR(report.view_precision, report.view_chance, 0.1);
  EXPECT_NEAR(report.third_precision, report.third_chance, 0.1);
  EXPECT_NEAR(report.room, 0.5, 0.1);
  EXPECT_NEAR(report.distance_error, report.distance_chance, 0.05);
}

TEST(Probe, HomesWithoutRoomsAreScoredWithoutThem) {
  const TemporaryFolder folder("probe");
  const auto set = panoramas();
  const auto features = features_of(set, folder.path() / "truth.safetensors", truth);
  ProbeConfig config = both_scans();
  config.room = {};
  config.viewpoints = 6;
  const ProbeReport report = probe_features(features, set, config);
  EXPECT_EQ(report.training, 6U);
  EXPECT_TRUE(std::isnan(report.room));
  EXPECT_TRUE(std::isnan(report.viewpoint_room));
  EXPECT_TRUE(std::isnan(report.room_chance));
  EXPECT_GT(report.view_precision, 0.95);
}

TEST(Probe, NamesWhatItLacks) {
  const TemporaryFolder folder("probe");
  const auto set = panoramas();
  const auto features = features_of(set, folder.path() / "short.safetensors", truth, 1);
  EXPECT_THAT(refusal<LookupError>([&] { probe_features(features, set, both_scans()); }),
              HasSubstr("viewpoint v7 of scan other"));
  ProbeConfig config = both_scans();
  config.unseen.clear();
  EXPECT_THAT(refusal<ArgumentError>([&] { probe_features(features, set, config); }),
              HasSubstr("unseen: no scan"));
  config = both_scans();
  config.viewpoints = 0;
  EXPECT_THAT(refusal<ArgumentError>([&] { probe_features(features, set, config); }),
              HasSubstr("viewpoints: 0"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural
