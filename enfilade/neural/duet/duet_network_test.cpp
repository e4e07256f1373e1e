#include "enfilade/neural/duet/duet_network.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/rng.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/core/optimizer.h"
#include "enfilade/neural/core/weights.h"
#include "tests/support/refusal.h"
#include "tests/support/small_duet.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural::duet {
namespace EN_UNIT {

using ::testing::HasSubstr;
using testing::integers;
using testing::tiny_duet;
using tests::refusal;
using tests::TemporaryFolder;
using Batch = testing::DuetBatch;

double difference(const at::Tensor& a, const at::Tensor& b) {
  const at::Tensor finite = at::isfinite(b);
  EXPECT_TRUE(at::equal(at::isfinite(a), finite)) << "other places are closed";
  const at::Tensor apart = (a - b).abs().masked_fill(finite.logical_not(), 0);
  return apart.numel() == 0 ? 0 : apart.max().item<double>();
}

TEST(DuetNetworkTest, ShapesAndClosedPlaces) {
  const DuetNetwork network(tiny_duet(), 1);
  const Batch batch;
  const c10::NoGradGuard no_gradients;
  const NavigationOutput out = batch.run(network);
  EXPECT_EQ(out.fused_logits.sizes(), at::IntArrayRef({2, 5}));
  EXPECT_EQ(out.local_logits.sizes(), at::IntArrayRef({2, 7}));
  EXPECT_EQ(out.object_logits.sizes(), at::IntArrayRef({2, 7}));
  const at::Tensor open = at::isfinite(out.fused_logits);
  EXPECT_TRUE(at::equal(open, integers({1, 0, 1, 1, 0, 1, 0, 0, 1, 1}).view({2, 5}).gt(0)));
  EXPECT_TRUE(at::equal(at::isfinite(out.object_logits), batch.navigation.objects));
}

TEST(DuetNetworkTest, FusionGivesTheLogitsOfVisitedNeighboursToAllOtherOpenNodes) {
  const DuetNetwork network(tiny_duet(), 1);
  const Batch batch;
  const c10::NoGradGuard no_gradients;
  const NavigationOutput out = batch.run(network);
  const at::Tensor global = out.global_logits[1], local = out.local_logits[1];
  const auto expect = [&](std::int64_t node, double value) {
    EXPECT_NEAR(out.fused_logits[1][node].item<double>(), value, 1e-6) << node;
  };
  // Token 1 is the visited node 1, token 2 the open node 4; node 3 is open and no candidate.
  // Token 3 is a candidate that is not on the map.
  expect(0, (global[0] + local[0]).item<double>());
  expect(4, (global[4] + local[2]).item<double>());
  expect(3, (global[3] + local[1]).item<double>());
}

TEST(DuetNetworkTest, PaddingChangesNothing) {
  const DuetNetwork network(tiny_duet(), 2);
  const Batch batch;
  const c10::NoGradGuard no_gradients;
  const NavigationOutput both = batch.run(network);
  for (const std::int64_t i : {0, 1}) {
    const NavigationOutput one = batch.row(i).run(network);
    const auto cut = [&](const at::Tensor& x, const at::Tensor& like) {
      return x[i].narrow(0, 0, like.size(1));
    };
    for (const auto& [all, alone] : {std::pair{both.fused_logits, one.fused_logits},
                                     std::pair{both.local_logits, one.local_logits},
                                     std::pair{both.object_logits, one.object_logits}}) {
      EXPECT_LT(difference(cut(all, alone), alone[0]), 1e-6) << i;
    }
  }
}

TEST(DuetNetworkTest, GradientsAreThoseOfFiniteDifferences) {
  const DuetNetwork network(tiny_duet(), 3);
  const Batch batch;
  EXPECT_THAT(testing::wrong_gradients(
                  network.weights(),
                  [&] {
                    const NavigationOutput out = batch.run(network);
                    const at::Tensor objects = at::log_softmax(out.object_logits, 1).select(1, 5);
                    return at::cross_entropy_loss(out.fused_logits, integers({2, 4})) - objects[0];
                  }),
              ::testing::IsEmpty());
}

TEST(DuetNetworkTest, DropoutFollowsItsSeed) {
  const DuetNetwork network(tiny_duet(), 1);
  const Batch batch;
  const c10::NoGradGuard no_gradients;
  const auto run = [&](std::uint64_t seed) {
    RateDropout dropout(seed, 0.3);
    return batch.run(network, &dropout).local_scores;
  };
  EXPECT_TRUE(at::equal(run(5), run(5)));
  EXPECT_FALSE(at::equal(run(5), run(6)));
}

TEST(DuetNetworkTest, SavedWeightsAreTheSameAndSayTheirSizes) {
  const TemporaryFolder folder("duet");
  const DuetNetwork network(tiny_duet(), 1);
  features::write_safetensors(folder.path() / "weights.safetensors",
                              core::as_arrays(network.weights()));
  const auto file = features::TensorFile::open(folder.path() / "weights.safetensors");
  const DuetConfig config = infer_config(file, 2);
  EXPECT_EQ(config.hidden, 8);
  EXPECT_EQ(config.feed_forward, 12);
  EXPECT_EQ(config.text_layers, 1);
  EXPECT_EQ(config.panorama_layers, 1);
  EXPECT_EQ(config.cross_layers, 1);
  EXPECT_EQ(config.vocabulary, 20);
  EXPECT_EQ(config.image, 5);
  EXPECT_EQ(config.object, 3);
  EXPECT_EQ(config.fusion, Fusion::kDynamic);
  EXPECT_TRUE(config.map_distances);
  const DuetNetwork loaded(config, file);
  ASSERT_EQ(loaded.weights().size(), network.weights().size());
  for (const auto& [name, values] : network.weights()) {
    EXPECT_TRUE(at::equal(values, loaded.weights().at(name))) << name;
  }
}

TEST(DuetNetworkTest, WeightsOfAnotherNetworkAreRefusedByName) {
  const TemporaryFolder folder("duet");
  const DuetNetwork network(tiny_duet(), 1);
  features::write_safetensors(folder.path() / "weights.safetensors",
                              core::as_arrays(network.weights()));
  const auto file = features::TensorFile::open(folder.path() / "weights.safetensors");
  DuetConfig other = tiny_duet();
  other.text_layers = 2;
  EXPECT_THAT(refusal<InvalidInput>([&] { DuetNetwork(other, file); }),
              HasSubstr("vln_bert.lang_encoder.layer.1.attention.self.query.weight"));
  other = tiny_duet();
  other.fusion = Fusion::kAverage;
  EXPECT_THAT(refusal<InvalidInput>([&] { DuetNetwork(other, file); }),
              HasSubstr("vln_bert.sap_fuse_linear.net.0.weight"));
}

void add_gradients(const DuetNetwork& network) {
  const NavigationOutput out = Batch().run(network);
  at::cross_entropy_loss(out.fused_logits, integers({2, 4})).backward();
}

TEST(DuetTrainingTest, AnUpdateIsAdamWs) {
  const DuetNetwork network(tiny_duet(), 1);
  core::OptimizerConfig config;
  config.rates.learning_rate = 1e-3;
  config.rates.weight_decay = 0.01;
  const at::Tensor& weight = network.weights().at("vln_bert.global_sap_head.net.0.weight");
  const at::Tensor before = weight.detach().clone();
  add_gradients(network);
  const at::Tensor gradient = weight.grad().clone();
  EXPECT_LT(core::WeightOptimizer(config).update(network.weights()), config.clip)
      << "so nothing is scaled down";
  // Of the first update the moments' quotient is g / (|g| + epsilon).
  const at::Tensor expected =
      before * (1 - 1e-3 * 0.01) - 1e-3 * gradient / (gradient.abs() + 1e-8);
  EXPECT_LT((weight.detach() - expected).abs().max().item<double>(), 1e-6);
  EXPECT_FALSE(weight.grad().defined()) << "gradients are forgotten";
}

TEST(DuetTrainingTest, GoesOnFromAFileAsIfNothingHadHappened) {
  for (const auto kind :
       {models::Optimizer::kAdam, models::Optimizer::kAdamW, models::Optimizer::kRmsProp}) {
    const TemporaryFolder folder("duet");
    const DuetNetwork network(tiny_duet(), 1);
    core::OptimizerConfig config;
    config.kind = kind;
    config.warm_up = 3;
    config.end = 9;
    core::WeightOptimizer optimizer(config);
    add_gradients(network);
    optimizer.update(network.weights());
    features::write_safetensors(folder.path() / "state.safetensors",
                                core::as_arrays(optimizer.state(network.weights())));
    const DuetNetwork other(tiny_duet(), 2);
    core::WeightOptimizer resumed(config);
    resumed.load(other.weights(), features::TensorFile::open(folder.path() / "state.safetensors"));
    EXPECT_EQ(resumed.updates(), 1U);
    EXPECT_EQ(resumed.rate(), optimizer.rate());
    add_gradients(network);
    optimizer.update(network.weights());
    add_gradients(other);
    resumed.update(other.weights());
    for (const auto& [name, values] : network.weights()) {
      EXPECT_TRUE(at::equal(values, other.weights().at(name))) << name;
    }
  }
}

TEST(OptimizerTest, TheRateRisesThenFallsToNothing) {
  core::OptimizerConfig config;
  config.warm_up = 2;
  config.end = 6;
  config.rates.learning_rate = 8;
  core::Weights weights{{"w", at::zeros({1}).set_requires_grad(true)}};
  core::WeightOptimizer optimizer(config);
  std::vector<double> rates;
  for (int i = 0; i < 7; ++i) {
    rates.push_back(optimizer.rate());
    weights.at("w").sum().backward();
    optimizer.update(weights);
  }
  EXPECT_THAT(rates, ::testing::ElementsAre(4, 8, 8, 6, 4, 2, 0));
}

TEST(DuetConfigTest, ImpossibleSizesAreNamed) {
  DuetConfig config = tiny_duet();
  config.heads = 3;
  EXPECT_THAT(refusal<ArgumentError>([&] { validate(config); }), HasSubstr("heads is 3"));
  EXPECT_THAT(refusal<ArgumentError>([] { duet_preset("duet-xl"); }), HasSubstr("duet-s"));
  EXPECT_EQ(duet_preset("duet").text_layers, 9);
  EXPECT_EQ(duet_preset("duet-s").hidden, 128);
  validate(duet_preset("duet-s"));
}

// A very small checkpoint with all that a released one has: the prefix of PyTorch's wrapper, the
// optimizer's state, a critic.
TEST(DuetCheckpointTest, ARecordedCheckpointIsRead) {
  const auto data = dataset::Dataset::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set";
  const auto folder = data->folder().parent_path() / "reference" / "agents_golden";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no recording in " << folder;
  const auto file = features::TensorFile::open(folder / "duet_reader.pt");
  EXPECT_NE(file.find("critic.state2value.0.weight"), nullptr);
  const DuetNetwork network(infer_config(file, 4), file);
  const auto about = nlohmann::json::parse(read_text_file(folder / "duet_reader.json"));
  const nlohmann::json& recorded = about["vln_bert"];
  ASSERT_EQ(recorded.size(), network.weights().size());
  for (const auto& [name, values] : network.weights()) {
    const nlohmann::json& row = recorded["module." + name];
    ASSERT_EQ(row.size(), 5U) << name;
    const at::Tensor numbers = values.detach().to(at::kDouble).view({-1});
    EXPECT_NEAR(row[1].get<double>(), numbers.sum().item<double>(), 1e-6) << name;
    EXPECT_NEAR(row[2].get<double>(), numbers.norm().item<double>(), 1e-6) << name;
    EXPECT_EQ(row[3].get<double>(), numbers[0].item<double>()) << name;
    EXPECT_EQ(row[4].get<double>(), numbers[-1].item<double>()) << name;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::duet
