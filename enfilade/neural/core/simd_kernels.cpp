// Compiled once for each instruction set that Highway knows; the best one is chosen at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "enfilade/neural/core/simd_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "enfilade/neural/core/simd_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace enfilade::neural::core {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Full = hn::ScalableTag<float>;
using One = hn::CappedTag<float, 1>;
template <class D>
using V = hn::Vec<D>;

// body(tag, i) for registers of elements from begin on, then for each element that is left.
template <class Body>
HWY_INLINE void for_elements(std::size_t begin, std::size_t end, const Body& body) {
  const Full full;
  const One one;
  std::size_t i = begin;
  for (; i + hn::Lanes(full) <= end; i += hn::Lanes(full)) body(full, i);
  for (; i < end; ++i) body(one, i);
}

// e^x = power (1 + rest), |rest| < 0.42. Faster than Highway's functions, which handle all x: the
// gates took most of the time with them. `power` is the nearest power of two, `rest` a Taylor
// series of what is left, whose eighth term is below a float's rounding. NaN stays NaN, as Min and
// Max return their second operand then. \pre |x| <= 87 or NaN
template <class D>
struct Exponential {
  V<D> power, rest;
};
template <class D>
HWY_INLINE Exponential<D> exponential(D d, V<D> x) {
  const hn::RebindToSigned<D> di;
  const auto nearest = hn::NearestInt(hn::Mul(x, hn::Set(d, 1.44269504F)));
  const auto n = hn::ConvertTo(d, nearest);
  // ln 2 in two parts, the first with so few digits that n times it is exact.
  const auto r =
      hn::NegMulAdd(n, hn::Set(d, 1.42860677e-6F), hn::NegMulAdd(n, hn::Set(d, 0.693145752F), x));
  const auto r2 = hn::Mul(r, r);
  const auto low = hn::MulAdd(r, hn::Set(d, 1.0F / 6), hn::Set(d, 0.5F));
  const auto middle = hn::MulAdd(r, hn::Set(d, 1.0F / 120), hn::Set(d, 1.0F / 24));
  const auto high = hn::MulAdd(r, hn::Set(d, 1.0F / 5040), hn::Set(d, 1.0F / 720));
  const auto series = hn::MulAdd(r2, hn::MulAdd(r2, high, middle), low);
  const auto exponent = hn::ShiftLeft<23>(hn::Add(nearest, hn::Set(di, 127)));
  return {hn::BitCast(d, exponent), hn::MulAdd(r2, series, r)};
}

template <class D>
HWY_INLINE V<D> sigmoid(D d, V<D> x) {
  const auto one = hn::Set(d, 1.0F);
  const auto bounded = hn::Max(hn::Set(d, -87.0F), hn::Min(hn::Set(d, 87.0F), hn::Neg(x)));
  const auto e = exponential(d, bounded);
  return hn::Div(one, hn::MulAdd(e.power, hn::Add(one, e.rest), one));
}

// (e^2|x| - 1) / (e^2|x| + 1). The numerator is computed without e^2|x|, so small ones keep all
// digits. The quotient is 1 from 40 on.
template <class D>
HWY_INLINE V<D> tanh_of(D d, V<D> x) {
  const auto size = hn::Abs(x);
  const auto e = exponential(d, hn::Min(hn::Set(d, 40.0F), hn::Add(size, size)));
  const auto less_one = hn::MulAdd(e.power, e.rest, hn::Sub(e.power, hn::Set(d, 1.0F)));
  return hn::CopySign(hn::Div(less_one, hn::Add(less_one, hn::Set(d, 2.0F))), x);
}

void lstm_forward(const LstmForward& step, std::size_t begin, std::size_t end) {
  const std::size_t h = step.rows.hidden;
  const float* bias = step.bias;
  for (std::size_t r = begin; r < end; ++r) {
    float* gates = step.rows.gates[r];
    const float* previous = step.rows.previous[r];
    float* cells = step.rows.cells[r];
    float* outputs = step.outputs[r];
    for_elements(0, h, [&](auto d, std::size_t j) HWY_ATTR {
      const auto sum = [&](std::size_t gate) HWY_ATTR {
        return hn::Add(hn::LoadU(d, gates + gate * h + j), hn::LoadU(d, bias + gate * h + j));
      };
      const auto in = sigmoid(d, sum(0)), forget = sigmoid(d, sum(1));
      const auto candidate = tanh_of(d, sum(2)), out = sigmoid(d, sum(3));
      const auto cell = hn::MulAdd(forget, hn::LoadU(d, previous + j), hn::Mul(in, candidate));
      hn::StoreU(in, d, gates + j);
      hn::StoreU(forget, d, gates + h + j);
      hn::StoreU(candidate, d, gates + 2 * h + j);
      hn::StoreU(out, d, gates + 3 * h + j);
      hn::StoreU(cell, d, cells + j);
      hn::StoreU(hn::Mul(out, tanh_of(d, cell)), d, outputs + j);
    });
  }
}

void lstm_backward(const LstmBackward& step, std::size_t begin, std::size_t end) {
  const std::size_t h = step.rows.hidden;
  for (std::size_t r = begin; r < end; ++r) {
    float* gates = step.rows.gates[r];
    const float* previous = step.rows.previous[r];
    const float* cells = step.rows.cells[r];
    const float* from_outputs = step.from_outputs[r];
    const float* from_next = step.from_next[r];
    float* gradient = step.cells[r];
    for_elements(0, h, [&](auto d, std::size_t j) HWY_ATTR {
      const auto one = hn::Set(d, 1.0F);
      const auto in = hn::LoadU(d, gates + j), forget = hn::LoadU(d, gates + h + j);
      const auto candidate = hn::LoadU(d, gates + 2 * h + j);
      const auto out = hn::LoadU(d, gates + 3 * h + j);
      const auto squashed = tanh_of(d, hn::LoadU(d, cells + j));
      const auto output = hn::Add(hn::LoadU(d, from_outputs + j), hn::LoadU(d, from_next + j));
      const auto cell = hn::MulAdd(hn::Mul(output, out), hn::NegMulAdd(squashed, squashed, one),
                                   hn::LoadU(d, gradient + j));
      // y (1 - y) of a sigmoid
      const auto slope = [&](auto y) HWY_ATTR { return hn::NegMulAdd(y, y, y); };
      hn::StoreU(hn::Mul(hn::Mul(cell, candidate), slope(in)), d, gates + j);
      hn::StoreU(hn::Mul(hn::Mul(cell, hn::LoadU(d, previous + j)), slope(forget)), d,
                 gates + h + j);
      hn::StoreU(hn::Mul(hn::Mul(cell, in), hn::NegMulAdd(candidate, candidate, one)), d,
                 gates + 2 * h + j);
      hn::StoreU(hn::Mul(hn::Mul(output, squashed), slope(out)), d, gates + 3 * h + j);
      hn::StoreU(hn::Mul(cell, forget), d, gradient + j);
    });
  }
}

void drop(const float* in, float* out, std::size_t n, const std::uint64_t* kept, float scale) {
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    const hn::RebindToUnsigned<decltype(d)> du;
    // A register has a power of two of lanes, at most 32; their bits are in one word.
    const auto bits = static_cast<std::uint32_t>(kept[i / 64] >> (i % 64));
    const auto lane = hn::Shl(hn::Set(du, 1U), hn::Iota(du, 0));
    const auto keep = hn::RebindMask(d, hn::TestBit(hn::Set(du, bits), lane));
    hn::StoreU(hn::IfThenElseZero(keep, hn::Mul(hn::LoadU(d, in + i), hn::Set(d, scale))), d,
               out + i);
  });
}

void tanh(float* x, std::size_t n) {
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    hn::StoreU(tanh_of(d, hn::LoadU(d, x + i)), d, x + i);
  });
}

void tanh_backward(const float* y, float* gradient, std::size_t n) {
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    const auto value = hn::LoadU(d, y + i);
    const auto slope = hn::NegMulAdd(value, value, hn::Set(d, 1.0F));
    hn::StoreU(hn::Mul(hn::LoadU(d, gradient + i), slope), d, gradient + i);
  });
}

float dot(const float* a, const float* b, std::size_t n) {
  const Full d;
  const std::size_t lanes = hn::Lanes(d);
  auto sum = hn::Zero(d);
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    sum = hn::MulAdd(hn::LoadU(d, a + i), hn::LoadU(d, b + i), sum);
  }
  float result = hn::GetLane(hn::SumOfLanes(d, sum));
  for (; i < n; ++i) result += a[i] * b[i];
  return result;
}

// Four rows of a by two of b: eight sums in registers. Each is dot()'s in the same order.
void scores_4x2(MatrixRows a, MatrixRows b, MatrixRows out, std::size_t i, std::size_t j,
                std::size_t k) {
  const Full d;
  const std::size_t lanes = hn::Lanes(d);
  auto s00 = hn::Zero(d), s01 = s00, s10 = s00, s11 = s00;
  auto s20 = s00, s21 = s00, s30 = s00, s31 = s00;
  std::size_t x = 0;
  for (; x + lanes <= k; x += lanes) {
    const auto b0 = hn::LoadU(d, b[j] + x), b1 = hn::LoadU(d, b[j + 1] + x);
    const auto a0 = hn::LoadU(d, a[i] + x), a1 = hn::LoadU(d, a[i + 1] + x);
    const auto a2 = hn::LoadU(d, a[i + 2] + x), a3 = hn::LoadU(d, a[i + 3] + x);
    s00 = hn::MulAdd(a0, b0, s00), s01 = hn::MulAdd(a0, b1, s01);
    s10 = hn::MulAdd(a1, b0, s10), s11 = hn::MulAdd(a1, b1, s11);
    s20 = hn::MulAdd(a2, b0, s20), s21 = hn::MulAdd(a2, b1, s21);
    s30 = hn::MulAdd(a3, b0, s30), s31 = hn::MulAdd(a3, b1, s31);
  }
  const auto put = [&](std::size_t row, std::size_t column, auto sum) HWY_ATTR {
    float result = hn::GetLane(hn::SumOfLanes(d, sum));
    for (std::size_t y = x; y < k; ++y) result += a[row][y] * b[column][y];
    out[row][column] = result;
  };
  put(i, j, s00), put(i, j + 1, s01), put(i + 1, j, s10), put(i + 1, j + 1, s11);
  put(i + 2, j, s20), put(i + 2, j + 1, s21), put(i + 3, j, s30), put(i + 3, j + 1, s31);
}

void scores(MatrixRows a, MatrixRows b, MatrixRows out, std::size_t m, std::size_t n,
            std::size_t k) {
  const std::size_t whole_m = m - m % 4, whole_n = n - n % 2;
  for (std::size_t j = 0; j < whole_n; j += 2) {
    for (std::size_t i = 0; i < whole_m; i += 4) scores_4x2(a, b, out, i, j, k);
    for (std::size_t i = whole_m; i < m; ++i) {
      out[i][j] = dot(a[i], b[j], k);
      out[i][j + 1] = dot(a[i], b[j + 1], k);
    }
  }
  for (std::size_t i = 0; i < m && whole_n < n; ++i) out[i][n - 1] = dot(a[i], b[n - 1], k);
}

// Rows i .. of the result, kCount of them, in columns j ..: a register each. Eight, as a product's
// sum is ready only four cycles later and two are begun in each.
template <std::size_t kCount, class D>
HWY_INLINE void combine_rows(const Combination& c, D d, std::size_t i, std::size_t j) {
  const auto start = [&](std::size_t r)
                         HWY_ATTR { return c.add ? hn::LoadU(d, c.out[i + r] + j) : hn::Zero(d); };
  const auto weight = [&](std::size_t r, std::size_t k)
                          HWY_ATTR { return hn::Set(d, c.a[(i + r) * c.a_row + k * c.a_column]); };
  if constexpr (kCount == 8) {
    auto s0 = start(0), s1 = start(1), s2 = start(2), s3 = start(3);
    auto s4 = start(4), s5 = start(5), s6 = start(6), s7 = start(7);
    for (std::size_t k = 0; k < c.k; ++k) {
      const auto b = hn::LoadU(d, c.b[k] + j);
      s0 = hn::MulAdd(weight(0, k), b, s0), s1 = hn::MulAdd(weight(1, k), b, s1);
      s2 = hn::MulAdd(weight(2, k), b, s2), s3 = hn::MulAdd(weight(3, k), b, s3);
      s4 = hn::MulAdd(weight(4, k), b, s4), s5 = hn::MulAdd(weight(5, k), b, s5);
      s6 = hn::MulAdd(weight(6, k), b, s6), s7 = hn::MulAdd(weight(7, k), b, s7);
    }
    hn::StoreU(s0, d, c.out[i] + j), hn::StoreU(s1, d, c.out[i + 1] + j);
    hn::StoreU(s2, d, c.out[i + 2] + j), hn::StoreU(s3, d, c.out[i + 3] + j);
    hn::StoreU(s4, d, c.out[i + 4] + j), hn::StoreU(s5, d, c.out[i + 5] + j);
    hn::StoreU(s6, d, c.out[i + 6] + j), hn::StoreU(s7, d, c.out[i + 7] + j);
  } else if constexpr (kCount == 4) {
    auto s0 = start(0), s1 = start(1), s2 = start(2), s3 = start(3);
    for (std::size_t k = 0; k < c.k; ++k) {
      const auto b = hn::LoadU(d, c.b[k] + j);
      s0 = hn::MulAdd(weight(0, k), b, s0), s1 = hn::MulAdd(weight(1, k), b, s1);
      s2 = hn::MulAdd(weight(2, k), b, s2), s3 = hn::MulAdd(weight(3, k), b, s3);
    }
    hn::StoreU(s0, d, c.out[i] + j), hn::StoreU(s1, d, c.out[i + 1] + j);
    hn::StoreU(s2, d, c.out[i + 2] + j), hn::StoreU(s3, d, c.out[i + 3] + j);
  } else {
    auto sum = start(0);
    for (std::size_t k = 0; k < c.k; ++k) {
      sum = hn::MulAdd(weight(0, k), hn::LoadU(d, c.b[k] + j), sum);
    }
    hn::StoreU(sum, d, c.out[i] + j);
  }
}

void combine(const Combination& c) {
  for_elements(0, c.n, [&](auto d, std::size_t j) HWY_ATTR {
    std::size_t i = 0;
    for (; i + 8 <= c.m; i += 8) combine_rows<8>(c, d, i, j);
    for (; i + 4 <= c.m; i += 4) combine_rows<4>(c, d, i, j);
    for (; i < c.m; ++i) combine_rows<1>(c, d, i, j);
  });
}

void softmax(float* x, std::size_t n) {
  const float most = *std::max_element(x, x + n);
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    const auto shifted = hn::Sub(hn::LoadU(d, x + i), hn::Set(d, most));
    const auto least = hn::Set(d, -87.0F);
    const auto e = exponential(d, hn::Max(least, shifted));
    // 0 below: a share that is not a normal number would slow down what is computed with it.
    hn::StoreU(hn::IfThenZeroElse(hn::Lt(shifted, least), hn::MulAdd(e.power, e.rest, e.power)), d,
               x + i);
  });
  float sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += x[i];
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    hn::StoreU(hn::Div(hn::LoadU(d, x + i), hn::Set(d, sum)), d, x + i);
  });
}

void softmax_backward(const float* y, float* gradient, std::size_t n) {
  const float sum = dot(y, gradient, n);
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    const auto from = hn::Sub(hn::LoadU(d, gradient + i), hn::Set(d, sum));
    hn::StoreU(hn::Mul(hn::LoadU(d, y + i), from), d, gradient + i);
  });
}

void multiply(const float* in, float* out, std::size_t n) {
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    hn::StoreU(hn::Mul(hn::LoadU(d, out + i), hn::LoadU(d, in + i)), d, out + i);
  });
}

void keep(const std::uint16_t* bits, std::uint32_t dropped, float kept, float* out, std::size_t n) {
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    const hn::RebindToSigned<decltype(d)> di;
    const hn::Rebind<std::uint16_t, decltype(d)> half;
    const auto drawn = hn::PromoteTo(di, hn::LoadU(half, bits + i));
    const auto drop = hn::Lt(drawn, hn::Set(di, static_cast<std::int32_t>(dropped)));
    hn::StoreU(hn::IfThenZeroElse(hn::RebindMask(d, drop), hn::Set(d, kept)), d, out + i);
  });
}

// The normal distribution: 1 - Phi(|x|) = e^(-x^2 / 2) times a polynomial of 1 / (1 + p |x|), to
// 1e-7 (Abramowitz and Stegun, 7.1.26, halved). NaN stays NaN.
template <class D>
struct Normal {
  V<D> share;    // Phi(x)
  V<D> density;  // sqrt(2 pi) phi(x)
};
template <class D>
HWY_INLINE Normal<D> normal(D d, V<D> x) {
  const auto half = hn::Mul(hn::Mul(x, x), hn::Set(d, -0.5F));
  const auto e = exponential(d, hn::Max(hn::Set(d, -87.0F), half));
  const auto density = hn::MulAdd(e.power, e.rest, e.power);
  const auto one = hn::Set(d, 1.0F);
  const auto t = hn::Div(one, hn::MulAdd(hn::Abs(x), hn::Set(d, 0.3275911F * 0.70710678F), one));
  auto sum = hn::Set(d, 0.5F * 1.061405429F);
  for (const float next :
       {0.5F * -1.453152027F, 0.5F * 1.421413741F, 0.5F * -0.284496736F, 0.5F * 0.254829592F}) {
    sum = hn::MulAdd(sum, t, hn::Set(d, next));
  }
  const auto tail = hn::Mul(hn::Mul(sum, t), density);
  const auto share = hn::IfThenElse(hn::Lt(x, hn::Zero(d)), tail, hn::Sub(one, tail));
  return {share, density};
}

void gelu(const float* in, float* out, std::size_t n) {
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    const auto x = hn::LoadU(d, in + i);
    hn::StoreU(hn::Mul(x, normal(d, x).share), d, out + i);
  });
}

void gelu_backward(const float* in, const float* gradient, float* out, std::size_t n) {
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    const auto x = hn::LoadU(d, in + i);
    const auto at = normal(d, x);
    const auto slope = hn::MulAdd(hn::Mul(x, hn::Set(d, 0.39894228F)), at.density, at.share);
    hn::StoreU(hn::Mul(hn::LoadU(d, gradient + i), slope), d, out + i);
  });
}

// Two sums in single precision: of the numbers, then of their squared distances from the mean.
void sum_norm(const SumNorm& step, std::size_t begin, std::size_t end) {
  const std::size_t n = step.width;
  const auto whole = static_cast<float>(n);
  for (std::size_t r = begin; r < end; ++r) {
    float* row = step.normalized + r * n;
    float* out = step.out + r * n;
    const Full full;
    auto sums = hn::Zero(full);
    float sum = 0;
    for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
      auto x = hn::LoadU(d, step.y + r * n + i);
      if (step.kept != nullptr) x = hn::Mul(x, hn::LoadU(d, step.kept + r * n + i));
      if (step.x != nullptr) x = hn::Add(x, hn::LoadU(d, step.x + r * n + i));
      hn::StoreU(x, d, row + i);
      if constexpr (std::is_same_v<decltype(d), Full>) {
        sums = hn::Add(sums, x);
      } else {
        sum += hn::GetLane(x);
      }
    });
    const float mean = (sum + hn::GetLane(hn::SumOfLanes(full, sums))) / whole;
    sums = hn::Zero(full);
    sum = 0;
    for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
      const auto x = hn::Sub(hn::LoadU(d, row + i), hn::Set(d, mean));
      hn::StoreU(x, d, row + i);
      if constexpr (std::is_same_v<decltype(d), Full>) {
        sums = hn::MulAdd(x, x, sums);
      } else {
        sum += hn::GetLane(x) * hn::GetLane(x);
      }
    });
    const float variance = (sum + hn::GetLane(hn::SumOfLanes(full, sums))) / whole;
    const float inverse = 1 / std::sqrt(variance + step.epsilon);
    step.inverse[r] = inverse;
    for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
      const auto x = hn::Mul(hn::LoadU(d, row + i), hn::Set(d, inverse));
      hn::StoreU(x, d, row + i);
      hn::StoreU(hn::MulAdd(x, hn::LoadU(d, step.scale + i), hn::LoadU(d, step.bias + i)), d,
                 out + i);
    });
  }
}

void sum_norm_backward(const SumNormBackward& step, std::size_t begin, std::size_t end) {
  const std::size_t n = step.width;
  const auto whole = static_cast<float>(n);
  for (std::size_t r = begin; r < end; ++r) {
    const float* gradient = step.gradient + r * n;
    const float* row = step.normalized + r * n;
    const Full full;
    auto sums = hn::Zero(full), products = sums;
    float sum = 0, product = 0;
    for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
      const auto from = hn::LoadU(d, gradient + i), x = hn::LoadU(d, row + i);
      const auto g = hn::Mul(from, hn::LoadU(d, step.scale + i));
      hn::StoreU(hn::MulAdd(from, x, hn::LoadU(d, step.to_scale + i)), d, step.to_scale + i);
      hn::StoreU(hn::Add(from, hn::LoadU(d, step.to_bias + i)), d, step.to_bias + i);
      if constexpr (std::is_same_v<decltype(d), Full>) {
        sums = hn::Add(sums, g);
        products = hn::MulAdd(g, x, products);
      } else {
        sum += hn::GetLane(g);
        product += hn::GetLane(g) * hn::GetLane(x);
      }
    });
    const float mean = (sum + hn::GetLane(hn::SumOfLanes(full, sums))) / whole;
    const float along = (product + hn::GetLane(hn::SumOfLanes(full, products))) / whole;
    const float inverse = step.inverse[r];
    for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
      const auto g = hn::Mul(hn::LoadU(d, gradient + i), hn::LoadU(d, step.scale + i));
      const auto rest =
          hn::NegMulAdd(hn::LoadU(d, row + i), hn::Set(d, along), hn::Sub(g, hn::Set(d, mean)));
      const auto to = hn::Mul(rest, hn::Set(d, inverse));
      hn::StoreU(to, d, step.to_x + r * n + i);
      if (step.kept != nullptr) {
        hn::StoreU(hn::Mul(to, hn::LoadU(d, step.kept + r * n + i)), d, step.to_y + r * n + i);
      }
    });
  }
}

void add_row(const float* in, float* out, std::size_t n) {
  for_elements(0, n, [&](auto d, std::size_t i) HWY_ATTR {
    hn::StoreU(hn::Add(hn::LoadU(d, out + i), hn::LoadU(d, in + i)), d, out + i);
  });
}

void adam(const AdamStep& step, std::size_t begin, std::size_t end) {
  for_elements(begin, end, [&](auto d, std::size_t i) HWY_ATTR {
    const auto weight = hn::LoadU(d, step.weights + i);
    const auto gradient =
        hn::MulAdd(weight, hn::Set(d, step.weight_decay), hn::LoadU(d, step.gradients + i));
    const auto first = hn::MulAdd(hn::LoadU(d, step.first + i), hn::Set(d, step.beta1),
                                  hn::Mul(gradient, hn::Set(d, 1 - step.beta1)));
    const auto second =
        hn::MulAdd(hn::LoadU(d, step.second + i), hn::Set(d, step.beta2),
                   hn::Mul(hn::Mul(gradient, gradient), hn::Set(d, 1 - step.beta2)));
    const auto divisor =
        hn::MulAdd(hn::Sqrt(second), hn::Set(d, step.scale), hn::Set(d, step.epsilon));
    hn::StoreU(first, d, step.first + i);
    hn::StoreU(second, d, step.second + i);
    hn::StoreU(hn::NegMulAdd(hn::Set(d, step.rate), hn::Div(first, divisor), weight), d,
               step.weights + i);
  });
}

// x * 0 is NaN for an infinite x or NaN, and a sum with NaN is NaN.
bool all_finite(const float* x, std::size_t n) {
  const Full d;
  const std::size_t lanes = hn::Lanes(d);
  auto sum = hn::Zero(d);
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) sum = hn::MulAdd(hn::LoadU(d, x + i), hn::Zero(d), sum);
  float result = hn::GetLane(hn::SumOfLanes(d, sum));
  for (; i < n; ++i) result += x[i] * 0.0F;
  return result == 0;
}

const SimdKernels* kernels() {
  static constexpr SimdKernels kKernels{
      .lstm_forward = lstm_forward,
      .lstm_backward = lstm_backward,
      .drop = drop,
      .tanh = tanh,
      .tanh_backward = tanh_backward,
      .scores = scores,
      .combine = combine,
      .softmax = softmax,
      .softmax_backward = softmax_backward,
      .add_row = add_row,
      .adam = adam,
      .all_finite = all_finite,
      .multiply = multiply,
      .keep = keep,
      .gelu = gelu,
      .gelu_backward = gelu_backward,
      .sum_norm = sum_norm,
      .sum_norm_backward = sum_norm_backward,
  };
  return &kKernels;
}

}  // namespace HWY_NAMESPACE
}  // namespace enfilade::neural::core
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace enfilade::neural::core {
namespace {
HWY_EXPORT(kernels);
}  // namespace

const SimdKernels& simd_kernels() noexcept { return *HWY_DYNAMIC_DISPATCH(kernels)(); }

}  // namespace enfilade::neural::core
#endif
