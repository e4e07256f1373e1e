// The loops against the standard library's functions in double precision, at all lengths that leave
// other rests behind whole registers.
#include "enfilade/neural/core/simd_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "enfilade/core/rng.h"

namespace enfilade::neural::core {
namespace EN_UNIT {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

double ulps(float found, double expected) {
  const auto nearest = static_cast<float>(expected);
  const float next = std::nextafter(std::abs(nearest), kInfinity);
  return std::abs(double{found} - expected) / (double{next} - std::abs(double{nearest}));
}

// Small, ordinary, and so large that the functions are flat.
std::vector<float> sweep() {
  std::vector<float> x{0.0F, -0.0F, 1e-30F, -1e-20F, 1e-7F, 88.0F, -88.0F, 1e30F, -1e30F};
  for (float y = -12; y < 12; y += 0.0037F) x.push_back(y);
  return x;
}

TEST(SimdKernels, TanhIsWithinThreeUnitsOfTheLastPlace) {
  std::vector<float> x = sweep();
  const std::vector<float> from = x;
  simd_kernels().tanh(x.data(), x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_LE(ulps(x[i], std::tanh(double{from[i]})), 3) << from[i];
    EXPECT_EQ(std::signbit(x[i]), std::signbit(from[i]));
  }
  std::vector<float> odd{kNan, kInfinity, -kInfinity};
  simd_kernels().tanh(odd.data(), odd.size());
  EXPECT_TRUE(std::isnan(odd[0]));
  EXPECT_EQ(odd[1], 1);
  EXPECT_EQ(odd[2], -1);
}

// Gates as such: all four sums the same, no cell before, so cell = sigmoid tanh.
TEST(SimdKernels, GatesAreWithinThreeUnitsOfTheLastPlace) {
  const std::vector<float> x = sweep();
  const std::size_t h = x.size();
  std::vector<float> gates, bias(4 * h), previous(h), cells(h), outputs(h);
  for (int gate = 0; gate < 4; ++gate) gates.insert(gates.end(), x.begin(), x.end());
  simd_kernels().lstm_forward({{{gates.data(), 4 * h}, {previous.data(), h}, {cells.data(), h}, h},
                               bias.data(),
                               {outputs.data(), h}},
                              0, 1);
  for (std::size_t i = 0; i < h; ++i) {
    // Below e^-87 the sigmoid stays where it is: 1e-38 is nothing to a cell.
    const double sigmoid = 1 / (1 + std::exp(-std::max(double{x[i]}, -87.0)));
    for (const std::size_t gate : {0U, 1U, 3U}) {
      EXPECT_LE(ulps(gates[gate * h + i], sigmoid), 3) << x[i];
    }
    EXPECT_LE(ulps(cells[i], sigmoid * std::tanh(double{x[i]})), 8) << x[i];
  }
}

TEST(SimdKernels, NotANumberComesOutOfEveryGate) {
  for (std::size_t gate = 0; gate < 4; ++gate) {
    const std::size_t h = 21;
    std::vector<float> gates(4 * h, 0.5F), bias(4 * h), previous(h, 1), cells(h), outputs(h);
    gates[gate * h + 3] = gates[gate * h + 20] = kNan;
    simd_kernels().lstm_forward(
        {{{gates.data(), 4 * h}, {previous.data(), h}, {cells.data(), h}, h},
         bias.data(),
         {outputs.data(), h}},
        0, 1);
    for (std::size_t i = 0; i < h; ++i) {
      EXPECT_EQ(std::isnan(outputs[i]), i == 3 || i == 20) << gate << " " << i;
    }
  }
}

TEST(SimdKernels, SoftmaxSumsToOneHoweverLargeTheScores) {
  Rng rng(1);
  for (std::size_t n = 1; n < 90; n += 7) {
    std::vector<float> x(n);
    double sum = 0;
    for (float& value : x) value = static_cast<float>(400 * rng.uniform() - 200);
    std::vector<float> from = x;
    simd_kernels().softmax(x.data(), n);
    const double most = *std::max_element(from.begin(), from.end());
    double total = 0;
    for (const float value : from) total += std::exp(double{value} - most);
    for (std::size_t i = 0; i < n; ++i) {
      sum += double{x[i]};
      EXPECT_NEAR(x[i], std::exp(double{from[i]} - most) / total, 1e-6);
    }
    EXPECT_NEAR(sum, 1, 1e-6);
  }
}

TEST(SimdKernels, DropsByTheMasksBits) {
  Rng rng(1);
  for (std::size_t n = 1; n < 140; n += 3) {
    std::vector<float> x(n, 3);
    std::vector<std::uint64_t> kept((n + 63) / 64);
    for (std::uint64_t& word : kept) word = rng.next();
    simd_kernels().drop(x.data(), x.data(), n, kept.data(), 2);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ(x[i], (kept[i / 64] >> (i % 64) & 1U) != 0 ? 6 : 0) << n << " " << i;
    }
  }
}

TEST(SimdKernels, SmallProductsAreProducts) {
  Rng rng(1);
  for (const std::size_t m : {1U, 4U, 7U}) {
    for (const std::size_t n : {1U, 2U, 5U}) {
      for (const std::size_t k : {1U, 16U, 37U}) {
        std::vector<float> a(m * k), b(n * k), out(m * n), combined(m * k, 1);
        for (float& x : a) x = static_cast<float>(rng.uniform() - 0.5);
        for (float& x : b) x = static_cast<float>(rng.uniform() - 0.5);
        simd_kernels().scores({a.data(), k}, {b.data(), k}, {out.data(), n}, m, n, k);
        // out (m, n) times b (n, k), added to ones.
        simd_kernels().combine(
            {out.data(), n, 1, {b.data(), k}, {combined.data(), k}, m, k, n, true});
        for (std::size_t i = 0; i < m; ++i) {
          for (std::size_t j = 0; j < n; ++j) {
            double sum = 0;
            for (std::size_t x = 0; x < k; ++x) sum += double{a[i * k + x]} * double{b[j * k + x]};
            EXPECT_NEAR(out[i * n + j], sum, 1e-6);
          }
          for (std::size_t x = 0; x < k; ++x) {
            double sum = 1;
            for (std::size_t j = 0; j < n; ++j)
              sum += double{out[i * n + j]} * double{b[j * k + x]};
            EXPECT_NEAR(combined[i * k + x], sum, 1e-6);
          }
        }
      }
    }
  }
}

TEST(SimdKernels, FindsWhatIsNotFiniteAnywhere) {
  for (const float bad : {kNan, kInfinity, -kInfinity}) {
    for (std::size_t i = 0; i < 40; ++i) {
      std::vector<float> x(40, 1e30F);
      EXPECT_TRUE(simd_kernels().all_finite(x.data(), x.size()));
      x[i] = bad;
      EXPECT_FALSE(simd_kernels().all_finite(x.data(), x.size())) << i;
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::core
