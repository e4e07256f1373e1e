#include "enfilade/neural/duet/pretraining_tasks.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>
#include <set>
#include <string>

#include "enfilade/core/errors.h"
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

at::Tensor guessed_words(const PretrainingNetwork& network, const Batch& batch,
                         const std::vector<std::int64_t>& masked) {
  const Tokens text = network.agent().encode_text(batch.ids, batch.lengths);
  return network.guess_words(text, batch.seen(network.agent()), integers(masked));
}

void save(const core::Weights& weights, const std::filesystem::path& file) {
  features::write_safetensors(file, core::as_arrays(weights));
}

double apart(const at::Tensor& a, const at::Tensor& b) {
  return (a - b).abs().max().item<double>();
}

TEST(PretrainingNetworkTest, HasThePublishedNames) {
  std::set<std::string> names;
  for (const core::ArraySpec& spec : pretraining_arrays_of(DuetConfig())) {
    names.insert(spec.name);
  }
  EXPECT_EQ(names.size(), 8U * 16U + 5U + 6U);
  for (const char* name : {"bert.local_encoder.encoder.x_layers.3.lang_self_att.self.query.weight",
                           "bert.global_encoder.encoder.x_layers.0.lang_output.LayerNorm.bias",
                           "mlm_head.predictions.transform.LayerNorm.weight",
                           "mlm_head.predictions.bias", "image_classifier.net.2.weight"}) {
    EXPECT_EQ(names.count(name), 1U) << name;
  }
  DuetConfig blind;
  blind.image = 0;
  EXPECT_EQ(pretraining_arrays_of(blind).size(), 8U * 16U + 5U);
}

TEST(PretrainingNetworkTest, GuessesWordsFromTextMapAndViews) {
  const PretrainingNetwork network(tiny_duet(), 1);
  const c10::NoGradGuard no_gradients;
  const at::Tensor words = guessed_words(network, Batch(), {1, 2, 8});
  EXPECT_EQ(words.sizes(), at::IntArrayRef({3, 20}));
  Batch others;
  others.ids[1][3] = 11;
  const at::Tensor other_text = guessed_words(network, others, {1, 2, 8});
  EXPECT_EQ(apart(other_text.narrow(0, 0, 2), words.narrow(0, 0, 2)), 0);
  EXPECT_GT(apart(other_text[2], words[2]), 0);
  others = {};
  others.navigation.steps[0][3] = 5;  // what the map says
  EXPECT_GT(apart(guessed_words(network, others, {1, 2, 8})[0], words[0]), 0);
  others = {};
  others.panorama.views[0][2].fill_(1);  // what is seen
  EXPECT_GT(apart(guessed_words(network, others, {1, 2, 8})[0], words[0]), 0);
}

TEST(PretrainingNetworkTest, PaddingChangesNoWord) {
  const PretrainingNetwork network(tiny_duet(), 2);
  const Batch batch;
  const c10::NoGradGuard no_gradients;
  const at::Tensor both = guessed_words(network, batch, {2, 9});
  EXPECT_LT(apart(guessed_words(network, batch.row(0), {2})[0], both[0]), 1e-6);
  EXPECT_LT(apart(guessed_words(network, batch.row(1), {3})[0], both[1]), 1e-6);
}

TEST(PretrainingNetworkTest, GradientsAreThoseOfFiniteDifferences) {
  const PretrainingNetwork network(tiny_duet(), 3);
  const Batch batch;
  EXPECT_THAT(testing::wrong_gradients(
                  network.weights(),
                  [&] {
                    const NavigationOutput out = batch.run(network.agent());
                    const at::Tensor views = network.guess_views(out, integers({1, 4, 8}));
                    return at::cross_entropy_loss(guessed_words(network, batch, {1, 2, 8}),
                                                  integers({4, 9, 7})) +
                           (views * views).mean() +
                           at::cross_entropy_loss(out.fused_logits, integers({2, 4})) -
                           at::log_softmax(out.object_logits, 1)[0][5];
                  }),
              ::testing::IsEmpty());
}

TEST(PretrainingNetworkTest, ItsFileIsThatOfAnAgentToo) {
  const TemporaryFolder folder("pretraining");
  const PretrainingNetwork network(tiny_duet(), 1);
  save(network.weights(), folder.path() / "all.safetensors");
  const auto file = features::TensorFile::open(folder.path() / "all.safetensors");
  const DuetNetwork agent(tiny_duet(), file);
  for (const auto& [name, values] : agent.weights()) {
    EXPECT_TRUE(at::equal(values, network.weights().at(name))) << name;
  }
  const PretrainingNetwork again(tiny_duet(), file, 2);
  EXPECT_EQ(again.weights().size(), network.weights().size());
  for (const auto& [name, values] : network.weights()) {
    EXPECT_TRUE(at::equal(values, again.weights().at(name))) << name;
  }
}

TEST(PretrainingNetworkTest, AnAgentsFileGetsNewHeadsAndHalfAHeadIsRefused) {
  const TemporaryFolder folder("pretraining");
  const PretrainingNetwork network(tiny_duet(), 1);
  save(network.agent().weights(), folder.path() / "agent.safetensors");
  const auto file = features::TensorFile::open(folder.path() / "agent.safetensors");
  const PretrainingNetwork again(tiny_duet(), file, 1);
  for (const auto& [name, values] : network.weights()) {
    EXPECT_TRUE(at::equal(values, again.weights().at(name))) << name;
  }
  core::Weights some = network.weights();
  some.erase("mlm_head.predictions.bias");
  save(some, folder.path() / "some.safetensors");
  const auto broken = features::TensorFile::open(folder.path() / "some.safetensors");
  EXPECT_THAT(refusal<InvalidInput>([&] { PretrainingNetwork(tiny_duet(), broken, 1); }),
              HasSubstr("mlm_head.predictions.bias"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::duet
