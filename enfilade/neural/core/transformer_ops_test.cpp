// The fused operations against the same of PyTorch's: values and all gradients.
#include "enfilade/neural/core/transformer_ops.h"

#include <ATen/ATen.h>
#include <ATen/CPUGeneratorImpl.h>
#include <ATen/Parallel.h>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "enfilade/neural/core/dropout.h"

namespace enfilade::neural::core {
namespace EN_UNIT {

// Sums of up to 90 products of numbers near 1, in another order.
constexpr double kTolerance = 2e-5;

at::Tensor random(at::IntArrayRef sizes, int seed) {
  const auto generator = at::detail::createCPUGenerator(static_cast<std::uint64_t>(seed));
  return at::randn(sizes, generator, at::kFloat).requires_grad_();
}

// What a result and its gradients by all inputs are, for a loss that weighs all its numbers.
template <class Call>
std::vector<at::Tensor> all_of(const std::vector<at::Tensor>& inputs, const Call& call) {
  for (const at::Tensor& x : inputs) at::Tensor(x).mutable_grad().reset();
  const at::Tensor out = call();
  (out * random(out.sizes(), 99).detach()).sum().backward();
  std::vector<at::Tensor> result{out.detach()};
  for (const at::Tensor& x : inputs) result.push_back(x.grad().clone());
  return result;
}

void expect_same(const std::vector<at::Tensor>& found, const std::vector<at::Tensor>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].sizes(), expected[i].sizes()) << i;
    EXPECT_LE((found[i] - expected[i]).abs().max().item<double>(), kTolerance) << i;
  }
}

struct Shape {
  std::int64_t n, a, b, heads, width;
};

class Attend : public ::testing::TestWithParam<Shape> {
 protected:
  at::Tensor query() const { return random({s.n, s.a, s.heads * s.width}, 1); }
  at::Tensor keys(int seed) const { return random({s.n, s.b, s.heads * s.width}, seed); }
  void compare(const std::vector<at::Tensor>& inputs, const at::Tensor& bias,
               const at::Tensor& kept) const {
    std::vector<at::Tensor> all = inputs;
    if (bias.defined() && bias.requires_grad()) all.push_back(bias);
    expect_same(
        all_of(all, [&] { return attend(inputs[0], inputs[1], inputs[2], bias, kept, s.heads); }),
        all_of(all, [&] {
          return attend_by_parts(inputs[0], inputs[1], inputs[2], bias, kept, s.heads);
        }));
  }

  Shape s = GetParam();
};

TEST_P(Attend, IsAsByParts) { compare({query(), keys(2), keys(3)}, {}, {}); }

TEST_P(Attend, IsAsByPartsWithPaddingAndDropout) {
  const at::Tensor lengths = at::arange(s.n).remainder(s.b).add(1).unsqueeze(1);
  const at::Tensor padding = at::arange(s.b).unsqueeze(0).ge(lengths);
  const at::Tensor kept = Dropout(4).mask({s.n, s.heads, s.a, s.b}, 0.3);
  for (const double far : {-10000.0, -std::numeric_limits<double>::infinity()}) {
    const at::Tensor bias =
        at::zeros({s.n, s.b}).masked_fill(padding, far).unsqueeze(1).unsqueeze(1);
    compare({query(), keys(2), keys(3)}, bias, kept);
  }
}

TEST_P(Attend, ForCardsIsAsByParts) {
  const at::Tensor lengths = at::arange(s.n).remainder(s.b).add(1).unsqueeze(1);
  const at::Tensor padding = at::arange(s.b).unsqueeze(0).ge(lengths);
  const at::Tensor far = at::zeros({s.n, s.b}).masked_fill(padding, -10000).view({s.n, 1, 1, s.b});
  for (const at::Tensor& bias : {at::Tensor(), far, random({s.n, 1, s.a, s.b}, 5)}) {
    std::vector<at::Tensor> inputs{query(), keys(2), keys(3)};
    if (bias.defined() && bias.requires_grad()) inputs.push_back(bias);
    expect_same(
        all_of(inputs,
               [&] { return attend_on_card(inputs[0], inputs[1], inputs[2], bias, 0, s.heads); }),
        all_of(inputs, [&] {
          return attend_by_parts(inputs[0], inputs[1], inputs[2], bias, {}, s.heads);
        }));
  }
}

TEST_P(Attend, GivesTheGradientOfItsBias) {
  compare({query(), keys(2), keys(3)}, random({s.n, 1, s.a, s.b}, 5), {});
  compare({query(), keys(2), keys(3)}, random({1, 1, 1, s.b}, 5), {});
}

INSTANTIATE_TEST_SUITE_P(Sizes, Attend,
                         ::testing::Values(Shape{1, 1, 1, 1, 1}, Shape{2, 3, 5, 2, 4},
                                           Shape{3, 37, 37, 4, 32}, Shape{2, 17, 90, 2, 64},
                                           Shape{5, 9, 16, 3, 7}));

TEST(AttendOnParts, OfOneProductIsAsOfThree) {
  const at::Tensor all = random({3, 8, 3 * 24}, 1);
  const auto call = [&](const auto& function) {
    const std::vector<at::Tensor> parts = all.chunk(3, -1);
    return function(parts[0], parts[1], parts[2], at::Tensor(), at::Tensor(), 2);
  };
  expect_same(all_of({all}, [&] { return call(attend); }),
              all_of({all}, [&] { return call(attend_by_parts); }));
}

TEST(SumNorm, IsAsByParts) {
  for (const std::int64_t width : {7, 16, 128, 771}) {
    const std::vector<at::Tensor> in{random({5, 29, width}, 1), random({5, 29, width}, 2),
                                     random({width}, 3), random({width}, 4)};
    const at::Tensor kept = Dropout(5).mask({5, 29, width}, 0.2);
    expect_same(
        all_of(in, [&] { return sum_norm(in[0], in[1], kept, in[2], in[3], 1e-12); }),
        all_of(in, [&] { return sum_norm_by_parts(in[0], in[1], kept, in[2], in[3], 1e-12); }));
    const std::vector<at::Tensor> alone{in[0], in[2], in[3]};
    expect_same(
        all_of(alone, [&] { return sum_norm(in[0], {}, {}, in[2], in[3], 1e-5); }),
        all_of(alone, [&] { return sum_norm_by_parts(in[0], {}, {}, in[2], in[3], 1e-5); }));
  }
}

// The bias is what is left.
TEST(SumNorm, OfOneNumberIsNothing) {
  const at::Tensor scale = random({1}, 1), bias = random({1}, 2);
  const at::Tensor out = sum_norm(random({6, 1}, 3), {}, {}, scale, bias, 1e-5);
  EXPECT_TRUE(out.equal(bias.expand({6, 1})));
}

TEST(Gelu, IsThatOfTheErrorFunction) {
  at::Tensor x = at::linspace(-20, 20, 40001).requires_grad_();
  const auto ours = all_of({x}, [&] { return core::gelu(x); });
  const auto exact = [&] {
    const at::Tensor wide = x.to(at::kDouble);
    return (wide * at::special_ndtr(wide)).to(at::kFloat);
  };
  const auto theirs = all_of({x}, exact);
  const at::Tensor size = x.detach().abs() + 1;
  for (const std::size_t i : {0U, 1U}) {
    EXPECT_LE(((ours[i] - theirs[i]) / size).abs().max().item<double>(), 5e-7) << i;
  }
  const at::Tensor odd = at::tensor({std::numeric_limits<float>::quiet_NaN(),
                                     std::numeric_limits<float>::infinity(), 1e30F, -1e30F, 0.0F});
  const at::Tensor out = core::gelu(odd);
  EXPECT_TRUE(out[0].isnan().item<bool>());
  EXPECT_EQ(out[1].item<float>(), std::numeric_limits<float>::infinity());
  EXPECT_EQ(out[2].item<float>(), 1e30F);
  EXPECT_NEAR(out[3].item<float>(), 0, 1e-6);
  EXPECT_EQ(out[4].item<float>(), 0);
}

// Three calls, as gradients are added up.
TEST(Linear, AddsTheGradientsOfItsLeaves) {
  const std::vector<at::Tensor> in{random({2, 5, 12}, 1), random({7, 12}, 2), random({7}, 3)};
  const auto three = [&](const auto& function) {
    return function(in[0], in[1], in[2]) + function(at::sin(in[0]), in[1], in[2]) +
           function(in[0].detach(), in[1], in[2]);
  };
  expect_same(all_of(in, [&] { return three(linear); }), all_of(in, [&] {
                return three([](const auto& x, const auto& weight, const auto& bias) {
                  return at::linear(x, weight, bias);
                });
              }));
}

TEST(Linear, NeedsNoBias) {
  const std::vector<at::Tensor> in{random({6, 12}, 1), random({7, 12}, 2)};
  expect_same(
      all_of(in, [&] { return core::linear(in[0], in[1]) * core::linear(at::sin(in[0]), in[1]); }),
      all_of(in, [&] { return at::linear(in[0], in[1]) * at::linear(at::sin(in[0]), in[1]); }));
}

TEST(Linear, OfNothingIsTheBias) {
  const std::vector<at::Tensor> in{random({3, 4, 0}, 1), random({7, 0}, 2), random({7}, 3)};
  expect_same({linear(in[0], in[1], in[2]).detach()}, {in[2].detach().expand({3, 4, 7})});
  linear(in[0], in[1], in[2]).sum().backward();
  EXPECT_EQ(in[1].grad().sizes(), in[1].sizes());
  EXPECT_TRUE(in[2].grad().eq(12).all().item<bool>());
}

TEST(Linear, OfPartsOfALeafHasItsGradientToo) {
  const std::vector<at::Tensor> in{random({4, 12}, 1), random({14, 12}, 2), random({7}, 3)};
  const auto call = [&](const auto& function) {
    return function(in[0], in[1].narrow(0, 3, 7), in[2]);
  };
  expect_same(all_of(in, [&] { return call(linear); }), all_of(in, [&] {
                return call([](const auto& x, const auto& weight, const auto& bias) {
                  return at::linear(x, weight, bias);
                });
              }));
}

TEST(TransformerOps, GiveTheSameBitsForAnyNumberOfThreads) {
  const std::vector<at::Tensor> in{random({9, 37, 64}, 1), random({9, 37, 64}, 2), random({64}, 3),
                                   random({64}, 4)};
  const int before = at::get_num_threads();
  std::vector<std::vector<at::Tensor>> results;
  for (const int threads : {1, 2, 3}) {
    at::set_num_threads(threads);
    results.push_back(all_of(in, [&] {
      return sum_norm(attend(in[0], in[1], in[1], {}, {}, 4), in[0], {}, in[2], in[3], 1e-12);
    }));
  }
  at::set_num_threads(before);
  for (const auto& result : results) {
    for (std::size_t i = 0; i < result.size(); ++i) {
      EXPECT_TRUE(result[i].equal(results[0][i])) << i;
    }
  }
}

TEST(TransformerOps, NotANumberIsNotLost) {
  at::Tensor x = random({1, 4, 8}, 1).detach().clone();
  x[0][2][3] = std::numeric_limits<float>::quiet_NaN();
  const at::Tensor out = attend(x, x, x, {}, {}, 1);
  EXPECT_TRUE(out.isnan().all().item<bool>());
  const at::Tensor one = at::ones({8});
  EXPECT_TRUE(sum_norm(x, {}, {}, one, one, 1e-5)[0][2].isnan().all().item<bool>());
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::core
