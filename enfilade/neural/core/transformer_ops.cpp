#include "enfilade/neural/core/transformer_ops.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>
#include <torch/version.h>
#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <vector>

#include "enfilade/neural/core/raw_tensors.h"
#include "enfilade/neural/core/simd_kernels.h"

namespace enfilade::neural::core {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

constexpr std::int64_t kLanes = 16;      // floats of the widest registers
constexpr std::int64_t kNormBlock = 64;  // rows whose gradients of scale and bias are summed first

bool is_ours(const at::Tensor& x) { return x.device().is_cpu() && x.scalar_type() == at::kFloat; }

// (n, length, heads * width), rows contiguous; those of chunk() need not follow each other.
struct Heads {
  explicit Heads(const at::Tensor& x)
      : data(x.data_ptr<float>()), sequence(x.stride(0)), row(size(x.stride(1))) {}
  MatrixRows of(std::int64_t n, std::int64_t column) const {
    return {data + n * sequence + column, row};
  }

  float* data;
  std::int64_t sequence;
  std::size_t row;
};

at::Tensor with_rows(const at::Tensor& x) { return x.stride(2) == 1 ? x : x.contiguous(); }

struct Sizes {
  Sizes(const at::Tensor& query, const at::Tensor& key, std::int64_t of_heads)
      : n(query.size(0)),
        a(query.size(1)),
        b(key.size(1)),
        heads(of_heads),
        width(query.size(2) / of_heads),
        stride((b + kLanes - 1) / kLanes * kLanes),
        scale(static_cast<float>(1 / std::sqrt(static_cast<double>(width)))) {}

  std::int64_t n, a, b, heads, width;
  std::int64_t stride;  // of a row of shares, so that products have whole registers
  float scale;
};

// Rows of one head as columns, each `stride` long; zeros behind.
void transpose(MatrixRows from, float factor, const Sizes& s, std::vector<float>& out) {
  out.assign(size(s.width * s.stride), 0);
  for (std::int64_t j = 0; j < s.b; ++j) {
    const float* row = from[size(j)];
    for (std::int64_t c = 0; c < s.width; ++c) out[size(c * s.stride + j)] = row[c] * factor;
  }
}

// (1 or n, 1, 1 or a, b)
struct Bias {
  explicit Bias(const at::Tensor& x) : data(numbers(x)) {
    if (data == nullptr) return;
    sequence = x.size(0) == 1 ? 0 : x.stride(0);
    row = x.size(2) == 1 ? 0 : x.stride(2);
  }
  const float* of(std::int64_t n, std::int64_t i) const { return data + n * sequence + i * row; }

  const float* data;
  std::int64_t sequence = 0, row = 0;
};

// An input without a gradient, which may be undefined.
struct Constant {
  at::Tensor value;
};

// Working memory of one thread.
struct Scratch {
  std::vector<float> columns, shares, gradients;
};

class Attention : public torch::autograd::Function<Attention> {
 public:
  // \param inputs query, key, value, and the bias if its gradient is asked for
  static at::Tensor forward(AutogradContext* context, at::TensorList inputs, const Constant& bias,
                            const Constant& factors, std::int64_t heads) {
    const at::Tensor &query = inputs[0], &key = inputs[1], &value = inputs[2];
    const at::Tensor& kept = factors.value;
    const Sizes s(query, key, heads);
    const Heads queries(query), keys(key), values(value);
    const Bias biases(bias.value);
    const at::Tensor shares = at::empty({s.n, heads, s.a, s.stride}, at::kFloat);
    at::Tensor out = at::empty({s.n, s.a, query.size(2)}, at::kFloat);
    const Heads outs(out);
    at::parallel_for(0, s.n, 1, [&](std::int64_t begin, std::int64_t end) {
      Scratch scratch;
      for (std::int64_t i = begin * heads; i < end * heads; ++i) {
        const std::int64_t n = i / heads, column = i % heads * s.width;
        float* own = numbers(shares) + i * s.a * s.stride;
        transpose(keys.of(n, column), s.scale, s, scratch.columns);
        multiply(queries.of(n, column), {scratch.columns.data(), size(s.stride)}, own, s);
        for (std::int64_t r = 0; r < s.a; ++r) {
          float* row = own + r * s.stride;
          if (biases.data != nullptr) simd_kernels().add_row(biases.of(n, r), row, size(s.b));
          simd_kernels().softmax(row, size(s.b));
        }
        const float* used = drop(own, kept, i, s, scratch.shares);
        simd_kernels().combine({used, size(s.stride), 1, values.of(n, column), outs.of(n, column),
                                size(s.a), size(s.width), size(s.b), false});
      }
    });
    context->save_for_backward({query, key, value, shares, kept});
    context->saved_data["heads"] = heads;
    context->saved_data["bias"] = inputs.size() == 4;
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor &query = saved[0], &key = saved[1], &value = saved[2], &kept = saved[4];
    const std::int64_t heads = context->saved_data["heads"].toInt();
    const Sizes s(query, key, heads);
    const at::Tensor gradient = with_rows(gradients[0]);
    const at::Tensor to_query = at::empty(query.sizes(), at::kFloat);
    const at::Tensor to_key = at::empty(key.sizes(), at::kFloat);
    const at::Tensor to_value = at::empty(value.sizes(), at::kFloat);
    at::Tensor to_bias;
    if (context->saved_data["bias"].toBool()) to_bias = at::zeros({s.n, 1, s.a, s.b}, at::kFloat);
    const Heads queries(query), keys(key), values(value), from(gradient);
    const Heads to_queries(to_query), to_keys(to_key), to_values(to_value);
    at::parallel_for(0, s.n, 1, [&](std::int64_t begin, std::int64_t end) {
      Scratch scratch;
      scratch.gradients.resize(size(s.a * s.stride));
      for (std::int64_t i = begin * heads; i < end * heads; ++i) {
        const std::int64_t n = i / heads, column = i % heads * s.width;
        const float* own = numbers(saved[3]) + i * s.a * s.stride;
        float* to_scores = scratch.gradients.data();
        transpose(values.of(n, column), 1, s, scratch.columns);
        multiply(from.of(n, column), {scratch.columns.data(), size(s.stride)}, to_scores, s);
        const float* used = drop(own, kept, i, s, scratch.shares);
        simd_kernels().combine({used, 1, size(s.stride), from.of(n, column),
                                to_values.of(n, column), size(s.b), size(s.width), size(s.a),
                                false});
        for (std::int64_t r = 0; r < s.a; ++r) {
          float* row = to_scores + r * s.stride;
          if (kept.defined()) {
            simd_kernels().multiply(numbers(kept) + (i * s.a + r) * s.b, row, size(s.b));
          }
          simd_kernels().softmax_backward(own + r * s.stride, row, size(s.b));
          if (to_bias.defined()) {
            simd_kernels().add_row(row, numbers(to_bias) + (n * s.a + r) * s.b, size(s.b));
          }
          for (std::int64_t c = 0; c < s.b; ++c) row[c] *= s.scale;
        }
        simd_kernels().combine({to_scores, size(s.stride), 1, keys.of(n, column),
                                to_queries.of(n, column), size(s.a), size(s.width), size(s.b),
                                false});
        simd_kernels().combine({to_scores, 1, size(s.stride), queries.of(n, column),
                                to_keys.of(n, column), size(s.b), size(s.width), size(s.a), false});
      }
    });
    variable_list result{to_query, to_key, to_value};
    if (to_bias.defined()) result.push_back(to_bias);
    result.resize(result.size() + 3);  // of what is no tensor
    return result;
  }

 private:
  // (a, width) times columns (width, stride)
  static void multiply(MatrixRows rows, MatrixRows columns, float* out, const Sizes& s) {
    simd_kernels().combine({rows.data,
                            rows.stride,
                            1,
                            columns,
                            {out, size(s.stride)},
                            size(s.a),
                            size(s.stride),
                            size(s.width),
                            false});
  }

  // The shares of one head that are used.
  static const float* drop(const float* shares, const at::Tensor& kept, std::int64_t head,
                           const Sizes& s, std::vector<float>& out) {
    if (!kept.defined()) return shares;
    out.assign(shares, shares + s.a * s.stride);
    for (std::int64_t r = 0; r < s.a; ++r) {
      simd_kernels().multiply(numbers(kept) + (head * s.a + r) * s.b, out.data() + r * s.stride,
                              size(s.b));
    }
    return out.data();
  }
};

class Norm : public torch::autograd::Function<Norm> {
 public:
  // \param inputs y, scale, bias, and x if there is one
  static at::Tensor forward(AutogradContext* context, at::TensorList inputs,
                            const Constant& factors, double epsilon) {
    const at::Tensor &y = inputs[0], &scale = inputs[1], &bias = inputs[2], &kept = factors.value;
    const at::Tensor x = inputs.size() == 4 ? inputs[3] : at::Tensor();
    const std::int64_t width = y.size(-1), rows = y.numel() / width;
    at::Tensor out = at::empty(y.sizes(), at::kFloat);
    const at::Tensor normalized = at::empty(y.sizes(), at::kFloat);
    const at::Tensor inverse = at::empty({rows}, at::kFloat);
    const SumNorm step{numbers(y),      numbers(kept), numbers(x),
                       numbers(scale),  numbers(bias), static_cast<float>(epsilon),
                       size(width),     numbers(out),  numbers(normalized),
                       numbers(inverse)};
    at::parallel_for(0, rows, kNormBlock, [&](std::int64_t begin, std::int64_t end) {
      simd_kernels().sum_norm(step, size(begin), size(end));
    });
    context->save_for_backward({normalized, inverse, kept, scale});
    context->saved_data["sum"] = x.defined();
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor &normalized = saved[0], &kept = saved[2], &scale = saved[3];
    const at::Tensor gradient = gradients[0].contiguous();
    const std::int64_t width = normalized.size(-1), rows = normalized.numel() / width;
    const std::int64_t blocks = (rows + kNormBlock - 1) / kNormBlock;
    const at::Tensor to_x = at::empty(normalized.sizes(), at::kFloat);
    const at::Tensor to_y = kept.defined() ? at::empty(normalized.sizes(), at::kFloat) : to_x;
    // A block of rows is summed by one thread, so the sums do not depend on how many there are.
    const at::Tensor sums = at::zeros({2, blocks, width}, at::kFloat);
    at::parallel_for(0, blocks, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t block = begin; block < end; ++block) {
        const SumNormBackward step{numbers(gradient),
                                   numbers(kept),
                                   numbers(scale),
                                   numbers(normalized),
                                   numbers(saved[1]),
                                   size(width),
                                   numbers(to_x),
                                   numbers(to_y),
                                   numbers(sums) + block * width,
                                   numbers(sums) + (blocks + block) * width};
        simd_kernels().sum_norm_backward(step, size(block * kNormBlock),
                                         size(std::min((block + 1) * kNormBlock, rows)));
      }
    });
    const at::Tensor both = sums.sum(1);
    variable_list result{to_y, both[0], both[1]};
    if (context->saved_data["sum"].toBool()) result.push_back(to_x);
    result.resize(result.size() + 2);  // of what is no tensor
    return result;
  }
};

constexpr std::int64_t kGeluBlock = 16384;  // numbers that are worth a thread

class Gelu : public torch::autograd::Function<Gelu> {
 public:
  static at::Tensor forward(AutogradContext* context, const at::Tensor& x) {
    at::Tensor out = at::empty(x.sizes(), at::kFloat);
    at::parallel_for(0, x.numel(), kGeluBlock, [&](std::int64_t begin, std::int64_t end) {
      simd_kernels().gelu(numbers(x) + begin, numbers(out) + begin, size(end - begin));
    });
    context->save_for_backward({x});
    return out;
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const at::Tensor x = context->get_saved_variables()[0];
    const at::Tensor gradient = gradients[0].contiguous();
    at::Tensor out = at::empty(x.sizes(), at::kFloat);
    at::parallel_for(0, x.numel(), kGeluBlock, [&](std::int64_t begin, std::int64_t end) {
      simd_kernels().gelu_backward(numbers(x) + begin, numbers(gradient) + begin,
                                   numbers(out) + begin, size(end - begin));
    });
    return {out};
  }
};

class Linear : public torch::autograd::Function<Linear> {
 public:
  // \param inputs x, weight, and the bias if there is one
  static at::Tensor forward(AutogradContext* context, at::TensorList inputs) {
    context->save_for_backward(inputs.vec());
    return at::linear(inputs[0], inputs[1], inputs.size() == 3 ? inputs[2] : at::Tensor());
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor &x = saved[0], &weight = saved[1];
    const std::int64_t n = gradients[0].numel() / weight.size(0);
    const at::Tensor gradient = gradients[0].reshape({n, weight.size(0)});
    const at::Tensor rows = x.reshape({n, weight.size(1)});  // of no columns if nothing is seen
    add_product(weight, gradient.t(), rows);
    if (saved.size() == 3) add_sum(saved[2], gradient.sum(0));
    variable_list result(saved.size());
    if (context->needs_input_grad(0)) result[0] = at::mm(gradient, weight).view(x.sizes());
    return result;
  }
};

}  // namespace

at::Tensor gelu(const at::Tensor& x) {
  return is_ours(x) ? Gelu::apply(x.contiguous()) : at::gelu(x);
}

at::Tensor linear(const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias) {
  if (!is_ours(x) || !adds_in_place(weight) || (bias.defined() && !adds_in_place(bias))) {
    return at::linear(x, weight, bias);
  }
  std::vector<at::Tensor> inputs{x, weight};
  if (bias.defined()) inputs.push_back(bias);
  return Linear::apply(at::TensorList(inputs));
}

at::Tensor attend_by_parts(const at::Tensor& query, const at::Tensor& key, const at::Tensor& value,
                           const at::Tensor& bias, const at::Tensor& kept, std::int64_t heads) {
  const std::int64_t n = query.size(0), hidden = query.size(2), width = hidden / heads;
  const auto split = [&](const at::Tensor& x) {
    return x.reshape({n, x.size(1), heads, width}).transpose(1, 2);
  };
  at::Tensor scores =
      at::matmul(split(query), split(key).transpose(2, 3)) / std::sqrt(static_cast<double>(width));
  if (bias.defined()) scores = scores + bias;
  at::Tensor shares = at::softmax(scores, -1);
  if (kept.defined()) shares = shares * kept;
  return at::matmul(shares, split(value)).transpose(1, 2).reshape({n, query.size(1), hidden});
}

at::Tensor attend(const at::Tensor& query, const at::Tensor& key, const at::Tensor& value,
                  const at::Tensor& bias, const at::Tensor& kept, std::int64_t heads) {
  if (!is_ours(query)) return attend_by_parts(query, key, value, bias, kept, heads);
  at::Tensor added = bias;
  if (bias.defined()) {
    if (bias.requires_grad()) {
      added = bias.expand({query.size(0), 1, query.size(1), key.size(1)});
    }
    if (added.stride(3) != 1) added = added.contiguous();
  }
  std::vector<at::Tensor> inputs{with_rows(query), with_rows(key), with_rows(value)};
  if (added.defined() && added.requires_grad()) inputs.push_back(added);
  return Attention::apply(at::TensorList(inputs), Constant{added}, Constant{kept}, heads);
}

at::Tensor attend_on_card(const at::Tensor& query, const at::Tensor& key, const at::Tensor& value,
                          const at::Tensor& bias, double rate, std::int64_t heads) {
#if TORCH_VERSION_MAJOR > 2 || (TORCH_VERSION_MAJOR == 2 && TORCH_VERSION_MINOR >= 1)
  const std::int64_t n = query.size(0), a = query.size(1), hidden = query.size(2);
  const auto split = [&](const at::Tensor& x) {
    return x.reshape({n, x.size(1), heads, hidden / heads}).transpose(1, 2);
  };
  std::optional<at::Tensor> added;
  if (bias.defined()) added = bias.to(query.scalar_type()).expand({n, heads, a, key.size(1)});
  return at::scaled_dot_product_attention(split(query), split(key), split(value), added, rate)
      .transpose(1, 2)
      .reshape({n, a, hidden});
#else
  at::Tensor kept;
  if (rate > 0) {
    const at::Tensor all =
        at::ones({query.size(0), heads, query.size(1), key.size(1)}, query.options());
    kept = std::get<0>(at::native_dropout(all, rate, true));
  }
  return attend_by_parts(query, key, value, bias, kept, heads);
#endif
}

at::Tensor sum_norm_by_parts(const at::Tensor& y, const at::Tensor& x, const at::Tensor& kept,
                             const at::Tensor& scale, const at::Tensor& bias, double epsilon) {
  at::Tensor sum = kept.defined() ? y * kept : y;
  if (x.defined()) sum = sum + x;
  return at::layer_norm(sum, scale.sizes(), scale, bias, epsilon);
}

at::Tensor sum_norm(const at::Tensor& y, const at::Tensor& x, const at::Tensor& kept,
                    const at::Tensor& scale, const at::Tensor& bias, double epsilon) {
  if (!is_ours(y)) return sum_norm_by_parts(y, x, kept, scale, bias, epsilon);
  std::vector<at::Tensor> inputs{y.contiguous(), scale, bias};
  if (x.defined()) inputs.push_back(x.contiguous());
  return Norm::apply(at::TensorList(inputs), Constant{kept}, epsilon);
}

}  // namespace enfilade::neural::core
