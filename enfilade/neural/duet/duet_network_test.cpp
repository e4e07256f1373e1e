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
#include "enfilade/neural/duet/training.h"
#include "enfilade/neural/encoders/random_weights.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural::duet {
namespace {

using ::testing::HasSubstr;
using tests::refusal;
using tests::TemporaryFolder;

DuetConfig tiny() {
  DuetConfig config;
  config.hidden = 8;
  config.heads = 2;
  config.feed_forward = 12;
  config.panorama_feed_forward = 12;
  config.text_layers = config.panorama_layers = config.cross_layers = 1;
  config.vocabulary = 20;
  config.positions = config.max_words = 16;
  config.image = 5;
  config.object = 3;
  config.steps = 20;
  return config;
}

at::Tensor random(const std::vector<std::int64_t>& shape, std::uint64_t seed) {
  Rng rng(seed);
  return encoders::normal(shape, 1, rng);
}

at::Tensor integers(const std::vector<std::int64_t>& values) {
  return at::tensor(values, at::kLong);
}

// Two episodes; the first is shorter in everything, so it has padding.
struct Batch {
  at::Tensor ids = integers({1, 5, 7, 2, 0, 0, 1, 9, 4, 8, 6, 2}).view({2, 6});
  at::Tensor lengths = integers({4, 6});
  PanoramaInput panorama;
  NavigationInput navigation;

  Batch() {
    panorama.views = random({2, 5, 5}, 1);
    panorama.view_counts = integers({4, 5});
    panorama.objects = random({2, 2, 3}, 2);
    panorama.object_counts = integers({2, 1});
    panorama.locations = random({2, 6, 7}, 3);
    panorama.types = integers({1, 1, 0, 0, 2, 2, 1, 1, 1, 0, 0, 2}).view({2, 6});
    navigation.steps = integers({0, 1, 0, 0, 0, 0, 1, 2, 0, 0}).view({2, 5});
    navigation.node_positions = random({2, 5, 7}, 4);
    navigation.node_mask = mask_of(integers({4, 5}), 5);
    navigation.visited = navigation.steps.gt(0);
    const at::Tensor metres = random({2, 5, 5}, 5).abs();
    navigation.distances = (metres + metres.transpose(1, 2)).contiguous();
    navigation.distances.select(1, 0).zero_();
    navigation.distances.select(2, 0).zero_();
    navigation.token_positions = random({2, 7, 14}, 6);
    navigation.choices = integers({1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0}).view({2, 7}).gt(0);
    navigation.objects = integers({0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 1}).view({2, 7}).gt(0);
    navigation.node_of_token =
        integers({-1, 2, 3, -1, -1, -1, -1, -1, 1, 4, -1, -1, -1, -1}).view({2, 7});
  }

  // One row without its padding.
  Batch row(std::int64_t i) const {
    Batch one = *this;
    const auto cut = [i](const at::Tensor& x, std::int64_t length) {
      return x.narrow(0, i, 1).narrow(1, 0, length).contiguous();
    };
    const std::int64_t words = i == 0 ? 4 : 6, views = i == 0 ? 4 : 5, objects = i == 0 ? 2 : 1;
    const std::int64_t nodes = i == 0 ? 4 : 5, tokens = views + objects;
    one.ids = cut(ids, words);
    one.lengths = lengths.narrow(0, i, 1);
    one.panorama = {cut(panorama.views, views),      panorama.view_counts.narrow(0, i, 1),
                    cut(panorama.objects, objects),  panorama.object_counts.narrow(0, i, 1),
                    cut(panorama.locations, tokens), cut(panorama.types, tokens)};
    NavigationInput& n = one.navigation;
    n.steps = cut(n.steps, nodes);
    n.node_positions = cut(n.node_positions, nodes);
    n.node_mask = cut(n.node_mask, nodes);
    n.visited = cut(n.visited, nodes);
    n.distances = cut(n.distances, nodes).narrow(2, 0, nodes);
    n.token_positions = cut(n.token_positions, tokens + 1);
    n.choices = cut(n.choices, tokens + 1);
    n.objects = cut(n.objects, tokens + 1);
    n.node_of_token = cut(n.node_of_token, tokens + 1);
    return one;
  }

  NavigationOutput run(const DuetNetwork& network, Dropout* dropout = nullptr) const {
    const Tokens text = network.encode_text(ids, lengths, dropout);
    const Tokens seen = network.encode_panorama(panorama, dropout);
    NavigationInput input = navigation;
    const std::int64_t n = ids.size(0), hidden = network.config().hidden;
    const at::Tensor stop = at::zeros({n, 1, hidden});
    input.tokens = at::cat({stop, seen.values}, 1);
    input.token_mask = at::cat({at::ones({n, 1}, at::kBool), seen.mask}, 1);
    // Any embedding will do for the nodes: here each is a token of the panorama.
    input.nodes = at::cat({stop, seen.values.narrow(1, 0, input.steps.size(1) - 1)}, 1);
    return network.navigate(text, input, dropout);
  }
};

double difference(const at::Tensor& a, const at::Tensor& b) {
  const at::Tensor finite = at::isfinite(b);
  EXPECT_TRUE(at::equal(at::isfinite(a), finite)) << "other places are closed";
  const at::Tensor apart = (a - b).abs().masked_fill(finite.logical_not(), 0);
  return apart.numel() == 0 ? 0 : apart.max().item<double>();
}

TEST(DuetNetworkTest, ShapesAndClosedPlaces) {
  const DuetNetwork network(tiny(), 1);
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
  const DuetNetwork network(tiny(), 1);
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
  const DuetNetwork network(tiny(), 2);
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
  DuetConfig config = tiny();
  const DuetNetwork network(config, 3);
  {
    // Larger weights than at the start of training, so that every part has its say.
    const c10::NoGradGuard no_gradients;
    Rng rng(4);
    for (const auto& [name, values] : network.weights()) {
      at::Tensor(values).add_(encoders::normal(values.sizes().vec(), 0.2, rng));
    }
  }
  const Batch batch;
  const auto loss = [&] {
    const NavigationOutput out = batch.run(network);
    const at::Tensor objects = at::log_softmax(out.object_logits, 1).select(1, 5);
    return at::cross_entropy_loss(out.fused_logits, integers({2, 4})) - objects[0];
  };
  loss().backward();
  const c10::NoGradGuard no_gradients;
  const double here = loss().item<double>();
  for (const auto& [name, values] : network.weights()) {
    const at::Tensor gradient = values.grad();
    ASSERT_TRUE(gradient.defined()) << name;
    const auto place = gradient.view({-1}).abs().argmax().item<std::int64_t>();
    const double expected = gradient.view({-1})[place].item<double>();
    at::Tensor number = at::Tensor(values).view({-1})[place];
    const float before = number.item<float>();
    constexpr float kStep = 1e-3F;  // float32: rounding is some 1e-3 of the quotient
    number.fill_(before + kStep);
    const double above = loss().item<double>();
    number.fill_(before - kStep);
    const double below = loss().item<double>();
    number.fill_(before);
    // ReLU has kinks, where the gradient is that of one side.
    const double apart = std::min({std::abs((above - below) / (2 * kStep) - expected),
                                   std::abs((above - here) / kStep - expected),
                                   std::abs((here - below) / kStep - expected)});
    EXPECT_LT(apart, 5e-3 + 0.03 * std::abs(expected)) << name;
  }
}

TEST(DuetNetworkTest, DropoutFollowsItsSeed) {
  const DuetNetwork network(tiny(), 1);
  const Batch batch;
  const c10::NoGradGuard no_gradients;
  const auto run = [&](std::uint64_t seed) {
    Dropout dropout(seed, 0.3);
    return batch.run(network, &dropout).local_scores;
  };
  EXPECT_TRUE(at::equal(run(5), run(5)));
  EXPECT_FALSE(at::equal(run(5), run(6)));
}

TEST(DuetNetworkTest, SavedWeightsAreTheSameAndSayTheirSizes) {
  const TemporaryFolder folder("duet");
  const DuetNetwork network(tiny(), 1);
  network.save(folder.path() / "weights.safetensors");
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
  const DuetNetwork network(tiny(), 1);
  network.save(folder.path() / "weights.safetensors");
  const auto file = features::TensorFile::open(folder.path() / "weights.safetensors");
  DuetConfig other = tiny();
  other.text_layers = 2;
  EXPECT_THAT(refusal<InvalidInput>([&] { DuetNetwork(other, file); }),
              HasSubstr("vln_bert.lang_encoder.layer.1.attention.self.query.weight"));
  other = tiny();
  other.fusion = Fusion::kAverage;
  EXPECT_THAT(refusal<InvalidInput>([&] { DuetNetwork(other, file); }),
              HasSubstr("vln_bert.sap_fuse_linear.net.0.weight"));
}

void add_gradients(const DuetNetwork& network) {
  const NavigationOutput out = Batch().run(network);
  at::cross_entropy_loss(out.fused_logits, integers({2, 4})).backward();
}

TEST(DuetTrainingTest, AnUpdateIsAdamWs) {
  const DuetNetwork network(tiny(), 1);
  detail::OptimizerConfig config;
  config.rates.learning_rate = 1e-3;
  config.rates.weight_decay = 0.01;
  const at::Tensor& weight = network.weights().at("vln_bert.global_sap_head.net.0.weight");
  const at::Tensor before = weight.detach().clone();
  add_gradients(network);
  const at::Tensor gradient = weight.grad().clone();
  EXPECT_LT(detail::Optimizer(config).update(network.weights()), config.clip)
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
    const DuetNetwork network(tiny(), 1);
    detail::OptimizerConfig config;
    config.kind = kind;
    config.warm_up = 3;
    config.end = 9;
    detail::Optimizer optimizer(config);
    add_gradients(network);
    optimizer.update(network.weights());
    features::write_safetensors(folder.path() / "state.safetensors",
                                detail::as_arrays(optimizer.state(network.weights())));
    const DuetNetwork other(tiny(), 2);
    detail::Optimizer resumed(config);
    resumed.load(other.weights(), arrays_of(tiny()),
                 features::TensorFile::open(folder.path() / "state.safetensors"));
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
  detail::OptimizerConfig config;
  config.warm_up = 2;
  config.end = 6;
  config.rates.learning_rate = 8;
  detail::Weights weights{{"w", at::zeros({1}).set_requires_grad(true)}};
  detail::Optimizer optimizer(config);
  std::vector<double> rates;
  for (int i = 0; i < 7; ++i) {
    rates.push_back(optimizer.rate());
    weights.at("w").sum().backward();
    optimizer.update(weights);
  }
  EXPECT_THAT(rates, ::testing::ElementsAre(4, 8, 8, 6, 4, 2, 0));
}

TEST(DuetConfigTest, ImpossibleSizesAreNamed) {
  DuetConfig config = tiny();
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

}  // namespace
}  // namespace enfilade::neural::duet
