#include "enfilade/neural/panoramic/panoramic_network.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <gmock/gmock.h>
#include <cmath>
#include <limits>
#include <vector>

#include "enfilade/core/errors.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural::panoramic {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::HasSubstr;

PanoramicConfig small(Subout subout = Subout::kMax, bool bidirectional = true) {
  PanoramicConfig config;
  config.vocabulary = 20;
  config.word_embedding = 6;
  config.action_embedding = 5;
  config.hidden = 8;
  config.image = 3;
  config.angle = 4;
  config.bidirectional = bidirectional;
  config.subout = subout;
  return config;
}

WordBatch words(std::vector<std::vector<std::int64_t>> sentences) {
  WordBatch batch;
  const auto longest = std::ssize(sentences[0]);
  batch.ids = at::zeros({std::ssize(sentences), longest}, at::kLong);
  for (std::size_t i = 0; i < sentences.size(); ++i) {
    batch.lengths.push_back(std::ssize(sentences[i]));
    for (std::size_t k = 0; k < sentences[i].size(); ++k) {
      batch.ids[static_cast<std::int64_t>(i)][static_cast<std::int64_t>(k)] = sentences[i][k];
    }
  }
  return batch;
}

StepInput input(std::int64_t n, std::int64_t candidates) {
  StepInput in;
  in.action = at::full({n, 4}, 0.5);
  in.views = at::arange(n * 36 * 7, at::kFloat).view({n, 36, 7}).sin();
  in.candidates = at::arange(n * candidates * 7, at::kFloat).view({n, candidates, 7}).cos();
  in.closed = at::zeros({n, candidates}, at::kBool);
  return in;
}

double largest_difference(const at::Tensor& a, const at::Tensor& b) {
  return (a - b).abs().max().item<double>();
}

TEST(PanoramicNetwork, SameSeedSameWeightsWithinPyTorchsBounds) {
  const PanoramicNetwork a(small(), 1), b(small(), 1), c(small(), 2);
  for (const auto& [name, values] : a.weights()) {
    EXPECT_TRUE(values.equal(b.weight(name))) << name;
    EXPECT_FALSE(values.equal(c.weight(name))) << name;
    EXPECT_TRUE(values.requires_grad()) << name;
    if (name == "encoder.embedding.weight") continue;
    EXPECT_LE(values.abs().max().item<double>(), 0.5) << name << ": 1 / sqrt(4) at most";
  }
  EXPECT_EQ(a.weight("encoder.embedding.weight")[0].abs().sum().item<double>(), 0) << "padding";
  EXPECT_THROW(a.weight("encoder.nothing"), LookupError);
}

// The published code's largest value runs over zeros at padding, its last state does not.
TEST(PanoramicNetwork, MaximumSeesThePaddingOfTheBatch) {
  const c10::NoGradGuard guard;
  for (const Subout subout : {Subout::kMax, Subout::kTanh}) {
    PanoramicNetwork network(small(subout), 1);
    const Encoding alone = network.encode(words({{4, 5, 2}}));
    const Encoding both = network.encode(words({{7, 8, 9, 10, 2}, {4, 5, 2}}));
    EXPECT_LT(largest_difference(both.context[1].narrow(0, 0, 3), alone.context[0]), 1e-6);
    EXPECT_LT(largest_difference(both.cell[1], alone.cell[0]), 1e-6);
    EXPECT_EQ(both.context[1].narrow(0, 3, 2).abs().sum().item<double>(), 0);
    const double start = largest_difference(both.start[1], alone.start[0]);
    if (subout == Subout::kTanh) {
      EXPECT_LT(start, 1e-6);
    } else {
      const at::Tensor most = std::get<0>(alone.context[0].max(0)).clamp_min(0);
      const at::Tensor expected =
          at::tanh(at::linear(most, network.weight("encoder.encoder2decoder.weight"),
                              network.weight("encoder.encoder2decoder.bias")));
      EXPECT_GT(start, 1e-4);
      EXPECT_LT(largest_difference(both.start[1], expected), 1e-6);
    }
  }
}

TEST(PanoramicNetwork, FinalStatesAreJoinedBackwardFirst) {
  const c10::NoGradGuard guard;
  PanoramicNetwork network(small(Subout::kTanh), 1);
  const Encoding encoding = network.encode(words({{4, 5, 2}}));
  const at::Tensor last =
      at::cat({encoding.context[0][0].narrow(0, 4, 4), encoding.context[0][2].narrow(0, 0, 4)}, 0);
  const at::Tensor expected =
      at::tanh(at::linear(last, network.weight("encoder.encoder2decoder.weight"),
                          network.weight("encoder.encoder2decoder.bias")));
  EXPECT_LT(largest_difference(encoding.start[0], expected), 1e-6);
}

TEST(PanoramicNetwork, StopIsZeroAndClosedIsMinusInfinity) {
  const c10::NoGradGuard guard;
  PanoramicNetwork network(small(), 1);
  const Encoding encoding = network.encode(words({{7, 8, 9, 2}, {4, 2}}));
  StepInput in = input(2, 3);
  in.candidates[0][2].zero_();
  in.candidates[1][1].zero_();
  in.candidates[1][2].zero_();
  in.closed[1][2] = true;
  const StepOutput out = network.step(encoding, {encoding.start, encoding.cell}, in);
  EXPECT_EQ(out.logits[0][2].item<float>(), 0);
  EXPECT_EQ(out.logits[1][1].item<float>(), 0);
  EXPECT_EQ(out.logits[1][2].item<float>(), -std::numeric_limits<float>::infinity());
  EXPECT_LT(largest_difference(out.view_attention.sum(1), at::ones({2})), 1e-6);
  EXPECT_LT(largest_difference(out.word_attention.sum(1), at::ones({2})), 1e-6);
  EXPECT_EQ(out.word_attention[1].narrow(0, 2, 2).abs().sum().item<float>(), 0);
  EXPECT_EQ(network.value(out.hidden).dim(), 1);
}

// The LSTM by its equations: its hidden state is the one after attention.
TEST(PanoramicNetwork, StepIsWhatItsEquationsSay) {
  const c10::NoGradGuard guard;
  PanoramicNetwork network(small(), 3);
  const Encoding encoding = network.encode(words({{7, 8, 9, 2}}));
  const StepInput in = input(1, 2);
  const StepOutput out = network.step(encoding, {encoding.start, encoding.cell}, in);
  const at::Tensor own =
      at::tanh(at::linear(in.action, network.weight("decoder.embedding.0.weight"),
                          network.weight("decoder.embedding.0.bias")));
  const at::Tensor gates =
      at::linear(at::cat({own, out.attended_view}, 1), network.weight("decoder.lstm.weight_ih"),
                 network.weight("decoder.lstm.bias_ih")) +
      at::linear(encoding.start, network.weight("decoder.lstm.weight_hh"),
                 network.weight("decoder.lstm.bias_hh"));
  const auto gate = [&](std::int64_t k) { return gates.narrow(1, 8 * k, 8); };
  const at::Tensor cell =
      at::sigmoid(gate(1)) * encoding.cell + at::sigmoid(gate(0)) * at::tanh(gate(2));
  const at::Tensor hidden = at::sigmoid(gate(3)) * at::tanh(cell);
  EXPECT_LT(largest_difference(out.next.cell, cell), 1e-6);
  EXPECT_LT(largest_difference(out.hidden, hidden), 1e-6);
}

TEST(PanoramicNetwork, DropoutFollowsItsSeedAndCanBeTurnedOff) {
  const c10::NoGradGuard guard;
  PanoramicNetwork network(small(), 1);
  const auto start = [&](std::optional<std::uint64_t> seed) {
    network.set_dropout(seed);
    return network.encode(words({{7, 8, 9, 2}})).start;
  };
  const at::Tensor plain = start(std::nullopt);
  EXPECT_TRUE(start(5).equal(start(5)));
  EXPECT_FALSE(start(5).equal(start(6)));
  EXPECT_FALSE(start(5).equal(plain));
  EXPECT_TRUE(start(std::nullopt).equal(plain));
}

TEST(PanoramicNetwork, WrongWordsAreTheCallersMistake) {
  PanoramicNetwork network(small(), 1);
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { network.encode(words({{20}})); }),
              HasSubstr("id 20, not from 0 to 19"));
  WordBatch rising = words({{4, 2, 3}, {4, 5, 2}});
  rising.lengths = {2, 3};
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { network.encode(rising); }),
              HasSubstr("a sentence of 3 after one of 2"));
}

TEST(PanoramicNetwork, FilesTellTheirSizesOrWhatIsWrong) {
  const tests::TemporaryFolder folder("panoramic");
  const auto file = folder.path() / "weights.safetensors";
  const PanoramicNetwork network(small(Subout::kMax, false), 4);
  auto arrays = core::as_arrays(network.weights());
  features::write_safetensors(file, arrays);
  const auto read = features::TensorFile::open(file);
  PanoramicConfig config = config_of(read, {});
  EXPECT_EQ(config.feature_dropout, PanoramicConfig().feature_dropout);
  EXPECT_EQ(config, small(Subout::kMax, false));
  const PanoramicNetwork loaded(config, read);
  for (const auto& [name, values] : network.weights()) {
    EXPECT_TRUE(values.equal(loaded.weight(name))) << name;
  }
  const PanoramicNetwork both_ways(small(), 4);
  auto wrapped = core::as_arrays(both_ways.weights());
  for (auto& array : wrapped) array.name = "module._orig_mod." + array.name;
  features::write_safetensors(folder.path() / "wrapped.safetensors", wrapped);
  EXPECT_EQ(config_of(features::TensorFile::open(folder.path() / "wrapped.safetensors"), {}),
            small());
  config.hidden = 10;
  EXPECT_THAT(tests::refusal<InvalidInput>([&] { PanoramicNetwork(config, read); }),
              AllOf(HasSubstr("decoder.lstm.weight_hh"), HasSubstr("[40, 10] is expected"),
                    HasSubstr("and 9 more")));
  arrays.erase(arrays.begin() + 8, arrays.end());
  features::write_safetensors(file, arrays);
  EXPECT_THAT(
      tests::refusal<InvalidInput>([&] { config_of(features::TensorFile::open(file), {}); }),
      AllOf(HasSubstr("missing-array"), HasSubstr("encoder.embedding.weight")));
}

TEST(PanoramicConfig, RefusesSizesThatCannotBe) {
  PanoramicConfig config = small();
  config.hidden = 7;
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { validate(config); }), HasSubstr("hidden: 7"));
  config = small();
  config.angle = 6;
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { validate(config); }), HasSubstr("angle: 6"));
  config = small();
  config.dropout = 1;
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { validate(config); }), HasSubstr("dropout"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::panoramic
