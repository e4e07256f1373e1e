// The network against loops in double precision, of sizes that loops manage.
#include "enfilade/neural/encoders/transformer_encoder.h"

#include <ATen/ATen.h>
#include <c10/core/InferenceMode.h>
#include <gtest/gtest.h>
#include <cmath>
#include <numbers>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/core/weights.h"

namespace enfilade::neural::encoders {
namespace EN_UNIT {

using Row = std::vector<double>;
using Rows = std::vector<Row>;

Row row(const at::Tensor& x) {
  const at::Tensor flat = x.flatten().contiguous();
  return {flat.data_ptr<float>(), flat.data_ptr<float>() + flat.numel()};
}

Row twin(const Linear& linear, const Row& x) {
  Row y;
  for (std::int64_t i = 0; i < linear.weight.size(0); ++i) {
    const Row weights = row(linear.weight[i]);
    double sum = linear.bias.defined() ? linear.bias[i].item<double>() : 0;
    for (std::size_t j = 0; j < x.size(); ++j) sum += weights[j] * x[j];
    y.push_back(sum);
  }
  return y;
}

Row twin(const LayerNorm& norm, const Row& x, double epsilon) {
  const Row weight = row(norm.weight), bias = row(norm.bias);
  const auto n = static_cast<double>(x.size());
  double mean = 0, variance = 0;
  for (const double v : x) mean += v / n;
  for (const double v : x) variance += (v - mean) * (v - mean) / n;
  Row y;
  for (std::size_t i = 0; i < x.size(); ++i) {
    y.push_back((x[i] - mean) / std::sqrt(variance + epsilon) * weight[i] + bias[i]);
  }
  return y;
}

double twin(Activation activation, double x) {
  if (activation == Activation::kQuickGelu) return x / (1 + std::exp(-1.702 * x));
  return x * (1 + std::erf(x / std::numbers::sqrt2)) / 2;
}

void add(const Row& from, Row& to) {
  for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i];
}

// Each token looks at all, head by head.
Rows attend(const TransformerSizes& s, const TransformerBlock& block, const Rows& x) {
  Rows qkv, seen;
  for (const Row& token : x) qkv.push_back(twin(block.qkv, twin(block.norm1, token, s.epsilon)));
  const auto width = static_cast<std::size_t>(s.width);
  const auto size = static_cast<std::size_t>(s.width / s.heads);
  for (const Row& from : qkv) {
    Row out(width);
    for (std::size_t head = 0; head < width; head += size) {
      Row shares;
      double sum = 0;
      for (const Row& at : qkv) {
        double product = 0;
        for (std::size_t i = 0; i < size; ++i) product += from[head + i] * at[width + head + i];
        shares.push_back(std::exp(product / std::sqrt(static_cast<double>(size))));
        sum += shares.back();
      }
      for (std::size_t t = 0; t < qkv.size(); ++t) {
        for (std::size_t i = 0; i < size; ++i) {
          out[head + i] += shares[t] / sum * qkv[t][2 * width + head + i];
        }
      }
    }
    seen.push_back(twin(block.proj, out));
  }
  return seen;
}

Rows embed(const TransformerSizes& s, const TransformerArrays& arrays, const at::Tensor& picture) {
  Rows x{row(arrays.class_token)};
  for (std::int64_t top = 0; top < s.picture; top += s.patch) {
    for (std::int64_t left = 0; left < s.picture; left += s.patch) {
      const at::Tensor patch = picture.slice(1, top, top + s.patch).slice(2, left, left + s.patch);
      x.push_back(twin(arrays.patches, row(patch)));
    }
  }
  for (std::size_t t = 0; t < x.size(); ++t) {
    add(row(arrays.positions[static_cast<std::int64_t>(t)]), x[t]);
    if (arrays.before.weight.defined()) x[t] = twin(arrays.before, x[t], s.epsilon);
  }
  return x;
}

Row twin(const TransformerSizes& s, const TransformerArrays& arrays, const at::Tensor& picture) {
  Rows x = embed(s, arrays, picture);
  for (const TransformerBlock& block : arrays.blocks) {
    const Rows seen = attend(s, block, x);
    for (std::size_t t = 0; t < x.size(); ++t) {
      add(seen[t], x[t]);
      Row hidden = twin(block.fc1, twin(block.norm2, x[t], s.epsilon));
      for (double& value : hidden) value = twin(s.activation, value);
      add(twin(block.fc2, hidden), x[t]);
    }
  }
  return twin(arrays.after, x[0], s.epsilon);
}

TransformerArrays random_arrays(const TransformerSizes& s, bool before) {
  Rng rng(7);
  const auto linear = [&](std::int64_t out, std::int64_t in) {
    return Linear{core::normal({out, in}, 0.4, rng), core::normal({out}, 0.3, rng)};
  };
  const auto norm = [&] {
    return LayerNorm{core::normal({s.width}, 0.3, rng) + 1, core::normal({s.width}, 0.3, rng)};
  };
  TransformerArrays arrays;
  arrays.patches = linear(s.width, 3 * s.patch * s.patch);
  if (before) arrays.patches.bias = at::Tensor();  // as in CLIP
  arrays.class_token = core::normal({s.width}, 1, rng);
  arrays.positions = core::normal({s.tokens(), s.width}, 0.5, rng);
  if (before) arrays.before = norm();
  for (std::int64_t i = 0; i < s.layers; ++i) {
    arrays.blocks.push_back({norm(), linear(3 * s.width, s.width), linear(s.width, s.width), norm(),
                             linear(s.hidden, s.width), linear(s.width, s.hidden)});
  }
  arrays.after = norm();
  return arrays;
}

class Twin : public ::testing::TestWithParam<bool> {};

TEST_P(Twin, IsTheNetwork) {
  TransformerSizes s{8, 4, 6, 3, 2, 10};
  if (GetParam()) s.activation = Activation::kQuickGelu;
  const TransformerArrays arrays = random_arrays(s, GetParam());
  const VisionTransformer network(s, arrays, c10::Device("cpu"));
  Rng rng(11);
  const at::Tensor pictures = core::normal({3, 3, s.picture, s.picture}, 1, rng);
  const c10::InferenceMode no_gradients;
  const at::Tensor found = network.run(pictures);
  ASSERT_EQ(found.sizes(), (std::vector<std::int64_t>{3, s.width}));
  for (std::int64_t n = 0; n < 3; ++n) {
    const Row expected = twin(s, arrays, pictures[n]), values = row(found[n]);
    // float32 in sums of some ten products; values are about 1.
    for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(values[i], expected[i], 2e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(ViTAndClip, Twin, ::testing::Bool());

}  // namespace EN_UNIT
}  // namespace enfilade::neural::encoders
