// The operations against the same of PyTorch's: values and all gradients.
#include "enfilade/neural/core/recurrent_ops.h"

#include <ATen/ATen.h>
#include <ATen/CPUGeneratorImpl.h>
#include <c10/core/GradMode.h>
#include <gtest/gtest.h>
#include <vector>

namespace enfilade::neural::core {
namespace EN_UNIT {

// Sums of up to 90 products of numbers near 1, in another order.
constexpr double kTolerance = 2e-5;

at::Tensor random(at::IntArrayRef sizes, std::uint64_t seed) {
  const auto generator = at::detail::createCPUGenerator(seed);
  return at::randn(sizes, generator, at::kFloat).requires_grad_();
}

// The results, and the gradients of the inputs by a loss that weighs all numbers of the results.
template <class Call>
std::vector<at::Tensor> all_of(const std::vector<at::Tensor>& inputs, const Call& call) {
  for (const at::Tensor& x : inputs) at::Tensor(x).mutable_grad().reset();
  std::vector<at::Tensor> results = call();
  at::Tensor loss = at::zeros({});
  for (std::size_t i = 0; i < results.size(); ++i) {
    loss = loss + (results[i] * random(results[i].sizes(), 90 + i).detach()).sum();
  }
  loss.backward();
  for (const at::Tensor& x : inputs) results.push_back(x.grad().clone());
  return results;
}

void expect_same(const std::vector<at::Tensor>& found, const std::vector<at::Tensor>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].sizes(), expected[i].sizes()) << i;
    EXPECT_LE(((found[i] - expected[i]) / (expected[i].abs() + 1)).abs().max().item<double>(),
              kTolerance)
        << i;
  }
}

class ReadLstm : public ::testing::TestWithParam<std::vector<std::int64_t>> {};

TEST_P(ReadLstm, IsPyTorchsInBothDirections) {
  const std::vector<std::int64_t> lengths = GetParam();
  const std::int64_t in = 7, hidden = 21, n = std::ssize(lengths);
  const at::Tensor x = random({n, lengths.front() + 1, in}, 1);  // and a step that nobody has
  std::vector<at::Tensor> weights;
  for (std::uint64_t way = 0; way < 2; ++way) {
    weights.push_back(random({4 * hidden, in}, 10 * way + 2));
    weights.push_back((random({4 * hidden, hidden}, 10 * way + 3).detach() * 0.3).requires_grad_());
    weights.push_back(random({4 * hidden}, 10 * way + 4));
    weights.push_back(random({4 * hidden}, 10 * way + 5));
  }
  std::vector<at::Tensor> inputs = weights;
  inputs.push_back(x);
  const auto ours = [&] {
    std::vector<at::Tensor> outputs, last, cells;
    for (const bool backwards : {false, true}) {
      const std::size_t at = backwards ? 4 : 0;
      const LstmRead read = read_lstm(
          x, lengths, {weights[at], weights[at + 1], weights[at + 2], weights[at + 3]}, backwards);
      outputs.push_back(read.outputs);
      last.push_back(read.hidden);
      cells.push_back(read.cell);
    }
    return std::vector<at::Tensor>{at::cat(outputs, 2), at::stack(last), at::stack(cells)};
  };
  const auto theirs = [&] {
    const at::Tensor zeros = at::zeros({2, n, hidden});
    const auto [packed, sizes] = at::_pack_padded_sequence(x, at::tensor(lengths, at::kLong), true);
    const auto [outputs, last, cells] =
        at::lstm(packed, sizes, {zeros, zeros}, weights, true, 1, 0.0, false, true);
    const auto [padded, unused] = at::_pad_packed_sequence(outputs, sizes, true, 0, x.size(1));
    return std::vector<at::Tensor>{padded, last, cells};
  };
  expect_same(all_of(inputs, ours), all_of(inputs, theirs));
}

// What cards compute, which reads backwards by turning rows around.
TEST_P(ReadLstm, IsTheSameByParts) {
  const std::vector<std::int64_t> lengths = GetParam();
  const std::int64_t in = 5, hidden = 9, n = std::ssize(lengths);
  const at::Tensor x = random({n, lengths.front() + 2, in}, 1);
  const std::vector<at::Tensor> inputs{x, random({4 * hidden, in}, 2),
                                       random({4 * hidden, hidden}, 3), random({4 * hidden}, 4),
                                       random({4 * hidden}, 5)};
  for (const bool backwards : {false, true}) {
    const auto by = [&](auto&& read_rows) {
      return all_of(inputs, [&] {
        const LstmRead read = read_rows(
            x, lengths, LstmWeights{inputs[1], inputs[2], inputs[3], inputs[4]}, backwards);
        return std::vector<at::Tensor>{read.outputs, read.hidden, read.cell};
      });
    };
    expect_same(by(read_lstm_by_parts), by(read_lstm));
  }
}

INSTANTIATE_TEST_SUITE_P(Lengths, ReadLstm,
                         ::testing::Values(std::vector<std::int64_t>{1},
                                           std::vector<std::int64_t>{5, 5, 3, 1},
                                           std::vector<std::int64_t>{17, 9, 9, 9, 2, 1}));

TEST(LstmStep, IsPyTorchsCell) {
  const std::vector<at::Tensor> in{random({5, 9}, 1),  random({5, 12}, 2),  random({5, 12}, 3),
                                   random({48, 9}, 4), random({48, 12}, 5), random({48}, 6),
                                   random({48}, 7)};
  // Twice, as gradients of weights are added up.
  const auto twice = [&](const auto& step) {
    const auto [out, next] = step(in[0], in[1], in[2]);
    const auto [hidden, cell] = step(at::sin(in[0]), out, next);
    return std::vector<at::Tensor>{hidden, cell, out};
  };
  expect_same(all_of(in,
                     [&] {
                       return twice([&](const auto& x, const auto& h, const auto& c) {
                         return lstm_step(x, h, c, {in[3], in[4], in[5], in[6]});
                       });
                     }),
              all_of(in, [&] {
                return twice([&](const auto& x, const auto& h, const auto& c) {
                  const auto [out, next] = at::lstm_cell(x, {h, c}, in[3], in[4], in[5], in[6]);
                  return std::pair(out, next);
                });
              }));
}

TEST(MemoryTest, IsAttendedToAsByParts) {
  const at::Tensor values = random({3, 9, 37}, 1), query = random({3, 37}, 2);
  const at::Tensor lengths = at::tensor({9, 4, 1}, at::kLong);
  // The second question depends on the first answer, as those of a walk do.
  const auto ask = [&](bool fused) {
    const AttentionMemory memory(values * 0.5, lengths);
    const auto once = [&](const at::Tensor& asked) {
      return fused ? memory.attend(asked) : memory.attend_by_parts(asked);
    };
    const at::Tensor first = once(query).first;
    const auto [second, shares] = once(at::tanh(first) + query);
    EXPECT_TRUE(shares[1].narrow(0, 4, 5).eq(0).all().item<bool>());
    EXPECT_NEAR(shares[1].sum().item<double>(), 1, 1e-6);
    return std::vector<at::Tensor>{first, second};
  };
  expect_same(all_of({values, query}, [&] { return ask(true); }),
              all_of({values, query}, [&] { return ask(false); }));
}

TEST(MemoryTest, WithoutGradientsGivesTheSame) {
  const at::Tensor values = random({2, 5, 8}, 1).detach(), query = random({2, 8}, 2);
  const at::Tensor lengths = at::tensor({5, 2}, at::kLong);
  const AttentionMemory memory(values, lengths);
  expect_same(all_of({query}, [&] { return std::vector{memory.attend(query).first}; }),
              all_of({query}, [&] { return std::vector{memory.attend_by_parts(query).first}; }));
  const c10::NoGradGuard no_gradients;
  EXPECT_FALSE(memory.attend(query).first.requires_grad());
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::core
