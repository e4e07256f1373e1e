// The network against plain loops, its gradients against PyTorch's, the loss by hand.
#include "enfilade/neural/continuous/network.h"

#include <ATen/ATen.h>
#include <gtest/gtest.h>
#include <cmath>
#include <numeric>

#include "enfilade/core/rng.h"

namespace enfilade::neural::continuous {
namespace EN_UNIT {

// Sums of up to 300 products of numbers near 1, in single precision and another order.
constexpr double kTolerance = 2e-5;

at::Tensor random(at::IntArrayRef sizes, std::uint64_t seed) {
  Rng rng(seed);
  at::Tensor values = at::empty(sizes, at::kFloat);
  for (std::int64_t i = 0; i < values.numel(); ++i) {
    values.data_ptr<float>()[i] = static_cast<float>(2 * rng.uniform() - 1);
  }
  return values.requires_grad_();
}

Sizes small_sizes() {
  Sizes sizes{9, 7, {}};
  sizes.own.word_embedding = 5;
  sizes.own.sentence = 6;
  sizes.own.picture = 4;
  sizes.own.depth = 3;
  sizes.own.action_embedding = 2;
  sizes.own.hidden = 8;
  return sizes;
}

using Row = std::vector<double>;

double sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

// Everything that the network computes of one walk, a number at a time.
class Plain {
 public:
  explicit Plain(const CeNetwork& network) : network_(network) {}

  Row read(const std::vector<std::int64_t>& words) const {
    Row hidden(network_.sizes().own.sentence, 0), cell(hidden);
    for (const std::int64_t word : words) {
      const Row x = row("instruction.embedding.weight", word);
      const Row in = linear("instruction.lstm.weight_ih_l0", "instruction.lstm.bias_ih_l0", x);
      const Row own =
          linear("instruction.lstm.weight_hh_l0", "instruction.lstm.bias_hh_l0", hidden);
      const std::size_t h = hidden.size();
      for (std::size_t i = 0; i < h; ++i) {
        const auto gate = [&](std::size_t g) { return in[g * h + i] + own[g * h + i]; };
        cell[i] = sigmoid(gate(1)) * cell[i] + sigmoid(gate(0)) * std::tanh(gate(2));
        hidden[i] = sigmoid(gate(3)) * std::tanh(cell[i]);
      }
    }
    return hidden;
  }

  Row step(const Row& sentence, const Row& picture, const Row& depth, std::int64_t previous,
           const Row& before) const {
    Row x = sentence;
    for (const Row& part : {linear("picture.weight", "picture.bias", picture),
                            linear("depth.weight", "depth.bias", depth)}) {
      for (const double value : part) x.push_back(std::max(value, 0.0));
    }
    for (const double value : row("action_embedding.weight", previous)) x.push_back(value);
    const Row in = linear("gru.weight_ih_l0", "gru.bias_ih_l0", x);
    const Row own = linear("gru.weight_hh_l0", "gru.bias_hh_l0", before);
    Row after = before;
    const std::size_t h = before.size();
    for (std::size_t i = 0; i < h; ++i) {
      const double reset = sigmoid(in[i] + own[i]), update = sigmoid(in[h + i] + own[h + i]);
      const double fresh = std::tanh(in[2 * h + i] + reset * own[2 * h + i]);
      after[i] = (1 - update) * fresh + update * before[i];
    }
    return after;
  }

  Row linear(const char* weight, const char* bias, const Row& x) const {
    const at::Tensor w = network_.weights().find(weight)->second;
    Row out;
    for (std::int64_t i = 0; i < w.size(0); ++i) {
      double sum = network_.weights().find(bias)->second[i].item<double>();
      for (std::int64_t j = 0; j < w.size(1); ++j) {
        sum += w[i][j].item<double>() * x[static_cast<std::size_t>(j)];
      }
      out.push_back(sum);
    }
    return out;
  }

 private:
  Row row(const char* table, std::int64_t at) const {
    return numbers(network_.weights().find(table)->second[at]);
  }

 public:
  static Row numbers(const at::Tensor& x) {
    Row out;
    for (std::int64_t i = 0; i < x.numel(); ++i) out.push_back(x[i].item<double>());
    return out;
  }

 private:
  const CeNetwork& network_;
};

TEST(CeNetwork, IsThatOfPlainLoops) {
  const CeNetwork network(small_sizes(), 3);
  const Plain plain(network);
  const std::vector<std::vector<std::int64_t>> texts{{7, 3, 2}, {7, 4, 5, 6, 2}, {7, 2}};
  const at::Tensor sentences = network.read(texts);
  const std::vector<std::int64_t> counts{3, 2, 2, 1};  // walks of 4, 3 and 1 steps
  const std::int64_t rows = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  const StepRows steps{random({rows, 7}, 5), random({rows, kDepthSize}, 6),
                       at::tensor({0, 0, 0, 2, 1, 3, 4, 2}, at::kLong), counts};
  const at::Tensor states = network.walk(sentences, steps, network.begin(3));
  const at::Tensor scores = network.score(states);
  std::vector<Row> state(3, Row(8, 0));
  std::int64_t at = 0;
  for (const std::int64_t count : counts) {
    for (std::size_t w = 0; w < static_cast<std::size_t>(count); ++w, ++at) {
      state[w] = plain.step(plain.read(texts[w]), Plain::numbers(steps.pictures[at]),
                            Plain::numbers(steps.depth[at]),
                            steps.previous[at].item<std::int64_t>(), state[w]);
      const Row expected = plain.linear("choice.weight", "choice.bias", state[w]);
      for (std::int64_t c = 0; c < kChoices; ++c) {
        EXPECT_NEAR(scores[at][c].item<double>(), expected[static_cast<std::size_t>(c)], kTolerance)
            << at << " " << c;
      }
    }
  }
}

TEST(CeNetwork, StepByStepIsTheWholeWalk) {
  const CeNetwork network(small_sizes(), 3);
  const at::Tensor sentences =
      network.read(std::vector<std::vector<std::int64_t>>{{7, 2}, {7, 5, 2}});
  const StepRows whole{
      random({4, 7}, 5), random({4, kDepthSize}, 6), at::tensor({0, 0, 2, 1}, at::kLong), {2, 2}};
  const at::Tensor states = network.walk(sentences, whole, network.begin(2));
  at::Tensor state = network.begin(2);
  for (std::int64_t t = 0; t < 2; ++t) {
    const StepRows one{whole.pictures.narrow(0, 2 * t, 2),
                       whole.depth.narrow(0, 2 * t, 2),
                       whole.previous.narrow(0, 2 * t, 2),
                       {2}};
    state = network.walk(sentences, one, state);
    EXPECT_LE((state - states.narrow(0, 2 * t, 2)).abs().max().item<double>(), kTolerance) << t;
  }
}

TEST(Gru, HasPyTorchsValuesAndGradients) {
  const std::int64_t in = 5, hidden = 6;
  const std::vector<std::int64_t> counts{3, 3, 2, 1};
  const GruWeights weights{random({3 * hidden, in}, 1), random({3 * hidden, hidden}, 2),
                           random({3 * hidden}, 3), random({3 * hidden}, 4)};
  const at::Tensor x = random({9, in}, 5), before = random({3, hidden}, 6).detach();
  const at::Tensor weigh = random({9, hidden}, 7).detach();
  const std::vector<at::Tensor> inputs{x, weights.input, weights.hidden, weights.input_bias,
                                       weights.hidden_bias};
  const auto gradients = [&](const at::Tensor& out) {
    for (const at::Tensor& input : inputs) at::Tensor(input).mutable_grad().reset();
    (out * weigh).sum().backward();
    std::vector<at::Tensor> all;
    for (const at::Tensor& input : inputs) all.push_back(input.grad().clone());
    return all;
  };
  std::vector<at::Tensor> parts;
  at::Tensor state = before;
  std::int64_t first = 0;
  for (const std::int64_t count : counts) {
    state = at::gru_cell(x.narrow(0, first, count), state.narrow(0, 0, count), weights.input,
                         weights.hidden, weights.input_bias, weights.hidden_bias);
    parts.push_back(state);
    first += count;
  }
  const at::Tensor theirs = at::cat(parts), ours = read_gru(x, counts, before, weights);
  EXPECT_LE((ours - theirs).abs().max().item<double>(), kTolerance);
  const auto expected = gradients(theirs), found = gradients(ours);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_LE((expected[i] - found[i]).abs().max().item<double>(), kTolerance) << i;
  }
}

TEST(InflectionLoss, IsThatByHand) {
  // Walk 0: forward, forward, stop, with probabilities 1/2, 1/4, 1/4 of these; walk 1: left, left,
  // with 1/4 and 1/2.
  const at::Tensor scores = at::zeros({5, 4});
  scores[0][1] = std::log(3.0);
  scores[3][2] = std::log(3.0);
  const at::Tensor teacher = at::tensor({1, 2, 1, 2, 0}, at::kLong);
  // Weights 3.2, 1, 3.2 of 7.4, and 3.2, 1 of 4.2: the first step is a change.
  const double first = (3.2 * std::log(2) + std::log(4) + 3.2 * std::log(4)) / 7.4;
  const double second = (3.2 * std::log(4) + std::log(2)) / 4.2;
  EXPECT_NEAR(inflection_loss(scores, teacher, {2, 2, 1}, 3.2).item<double>(), (first + second) / 2,
              1e-6);
  // All weights equal: the mean over steps.
  EXPECT_NEAR(inflection_loss(scores, teacher, {2, 2, 1}, 1).item<double>(),
              ((std::log(2) + 2 * std::log(4)) / 3 + (std::log(4) + std::log(2)) / 2) / 2, 1e-6);
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::continuous
