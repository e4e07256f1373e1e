#include "enfilade/neural/core/recurrent_ops.h"

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>
#include <algorithm>
#include <limits>

#include "enfilade/core/check.h"
#include "enfilade/neural/core/raw_tensors.h"
#include "enfilade/neural/core/simd_kernels.h"

namespace enfilade::neural::core {
namespace {

using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

MatrixRows rows_of(const at::Tensor& x, std::int64_t first = 0) {
  return {numbers(x) + first * x.stride(0), size(x.stride(0))};
}

at::Tensor tensor_of(const std::vector<std::int64_t>& values) {
  return at::tensor(values, at::kLong);
}

// Steps one after the other, of each the rows that are not yet at their end.
struct Packing {
  Packing(const std::vector<std::int64_t>& lengths, std::int64_t longest, bool backwards) {
    for (std::int64_t t = 0; t < lengths.front(); ++t) {
      first.push_back(std::ssize(places));
      for (std::int64_t r = 0; r < std::ssize(lengths) && lengths[size(r)] > t; ++r) {
        if (t > 0) before.push_back(first[size(t) - 1] + r);
        places.push_back(r * longest + (backwards ? lengths[size(r)] - 1 - t : t));
      }
    }
    first.push_back(std::ssize(places));
    for (std::int64_t r = 0; r < std::ssize(lengths); ++r) {
      last.push_back(first[size(lengths[size(r)]) - 1] + r);
    }
  }
  std::int64_t steps() const { return std::ssize(first) - 1; }
  std::int64_t rows(std::int64_t t) const { return first[size(t) + 1] - first[size(t)]; }

  std::vector<std::int64_t> first;   // packed row of each step, and the number of packed rows
  std::vector<std::int64_t> places;  // of each packed row, among all steps of the padded rows
  std::vector<std::int64_t> before;  // from the second step on: the packed row of the step before
  std::vector<std::int64_t> last;    // packed row of each row's end
};

at::Tensor spread(const at::Tensor& packed, const at::Tensor& places, std::int64_t n,
                  std::int64_t longest) {
  const at::Tensor all = at::zeros({n * longest, packed.size(1)}, at::kFloat);
  all.index_copy_(0, places, packed);
  return all.view({n, longest, packed.size(1)});
}

class Lstm : public torch::autograd::Function<Lstm> {
 public:
  static variable_list forward(AutogradContext* context, const at::Tensor& x,
                               const at::Tensor& input, const at::Tensor& hidden,
                               const at::Tensor& input_bias, const at::Tensor& hidden_bias,
                               const std::vector<std::int64_t>& lengths, bool backwards) {
    const std::int64_t n = x.size(0), longest = x.size(1), h = hidden.size(1);
    const Packing packing(lengths, longest, backwards);
    const at::Tensor places = tensor_of(packing.places);
    const at::Tensor steps = x.reshape({n * longest, x.size(2)}).index_select(0, places);
    const at::Tensor gates = at::mm(steps, input.t());
    const at::Tensor bias = input_bias + hidden_bias;
    const at::Tensor outputs = at::empty({steps.size(0), h}, at::kFloat);
    const at::Tensor cells = at::empty({steps.size(0), h}, at::kFloat);
    const at::Tensor nothing = at::zeros({n, h}, at::kFloat);
    for (std::int64_t t = 0; t < packing.steps(); ++t) {
      const std::int64_t first = packing.first[size(t)], rows = packing.rows(t);
      const std::int64_t before = t == 0 ? 0 : packing.first[size(t) - 1];
      if (t > 0) {
        gates.narrow(0, first, rows).addmm_(outputs.narrow(0, before, rows), hidden.t());
      }
      const MatrixRows previous = t == 0 ? rows_of(nothing) : rows_of(cells, before);
      simd_kernels().lstm_forward(
          {{rows_of(gates, first), previous, rows_of(cells, first), size(h)},
           numbers(bias),
           rows_of(outputs, first)},
          0, size(rows));
    }
    const at::Tensor last = tensor_of(packing.last);
    context->save_for_backward({steps, gates, cells, outputs, input, hidden, places, last});
    context->saved_data["lengths"] = lengths;
    context->saved_data["backwards"] = backwards;
    context->saved_data["longest"] = longest;
    return {spread(outputs, places, n, longest), outputs.index_select(0, last),
            cells.index_select(0, last)};
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor &steps = saved[0], &cells = saved[2], &outputs = saved[3], &input = saved[4],
                     &hidden = saved[5], &places = saved[6], &last = saved[7];
    const std::int64_t longest = context->saved_data["longest"].toInt();
    const std::int64_t n = last.size(0), h = hidden.size(1);
    const Packing packing(context->saved_data["lengths"].toIntVector(), longest,
                          context->saved_data["backwards"].toBool());
    const at::Tensor from_outputs = gradients[0].reshape({n * longest, h}).index_select(0, places);
    from_outputs.index_add_(0, last, gradients[1]);
    const at::Tensor to_gates = saved[1].clone();
    const at::Tensor to_cells = gradients[2].clone();
    const at::Tensor from_next = at::zeros({n, h}, at::kFloat);
    const at::Tensor nothing = at::zeros({n, h}, at::kFloat);
    for (std::int64_t t = packing.steps() - 1; t >= 0; --t) {
      const std::int64_t first = packing.first[size(t)], rows = packing.rows(t);
      const MatrixRows previous =
          t == 0 ? rows_of(nothing) : rows_of(cells, packing.first[size(t) - 1]);
      simd_kernels().lstm_backward(
          {{rows_of(to_gates, first), previous, rows_of(cells, first), size(h)},
           rows_of(from_outputs, first),
           rows_of(from_next),
           rows_of(to_cells)},
          0, size(rows));
      if (t == 0) break;
      at::Tensor next = from_next.narrow(0, 0, rows);
      at::mm_out(next, to_gates.narrow(0, first, rows), hidden);
    }
    const at::Tensor later =
        to_gates.narrow(0, packing.rows(0), to_gates.size(0) - packing.rows(0));
    const at::Tensor to_hidden =
        at::mm(later.t(), outputs.index_select(0, tensor_of(packing.before)));
    const at::Tensor to_bias = to_gates.sum(0);
    const at::Tensor to_x = context->needs_input_grad(0)
                                ? spread(at::mm(to_gates, input), places, n, longest)
                                : at::Tensor();
    return {to_x, at::mm(to_gates.t(), steps), to_hidden, to_bias, to_bias, {}, {}};
  }
};

class LstmStep : public torch::autograd::Function<LstmStep> {
 public:
  static variable_list forward(AutogradContext* context, const at::Tensor& x,
                               const at::Tensor& before, const at::Tensor& cell,
                               const at::Tensor& input, const at::Tensor& hidden,
                               const at::Tensor& input_bias, const at::Tensor& hidden_bias) {
    const at::Tensor gates = at::mm(x, input.t()).addmm_(before, hidden.t());
    const at::Tensor bias = input_bias + hidden_bias;
    at::Tensor next = at::empty_like(cell), out = at::empty_like(cell);
    simd_kernels().lstm_forward({{rows_of(gates), rows_of(cell), rows_of(next), size(cell.size(1))},
                                 numbers(bias),
                                 rows_of(out)},
                                0, size(cell.size(0)));
    context->save_for_backward(
        {x, before, cell, input, hidden, input_bias, hidden_bias, gates, next});
    return {out, next};
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor &x = saved[0], &before = saved[1], &cell = saved[2], &input = saved[3],
                     &hidden = saved[4];
    const at::Tensor to_gates = saved[7].clone(), to_cell = gradients[1].clone();
    const at::Tensor from_outputs = gradients[0].contiguous();
    const at::Tensor nothing = at::zeros_like(cell);
    simd_kernels().lstm_backward(
        {{rows_of(to_gates), rows_of(cell), rows_of(saved[8]), size(cell.size(1))},
         rows_of(from_outputs),
         rows_of(nothing),
         rows_of(to_cell)},
        0, size(cell.size(0)));
    add_product(input, to_gates.t(), x);
    add_product(hidden, to_gates.t(), before);
    const at::Tensor to_bias = to_gates.sum(0);
    add_sum(saved[5], to_bias);
    add_sum(saved[6], to_bias);
    return {at::mm(to_gates, input), at::mm(to_gates, hidden), to_cell, {}, {}, {}, {}};
  }
};

// Inputs that have no gradient here.
struct Constants {
  at::Tensor values, lengths, sum;
};

// Leads to what was attended to. Autograd comes here after all attentions have added to the sum.
class Link : public torch::autograd::Function<Link> {
 public:
  static at::Tensor forward(AutogradContext* context, const at::Tensor& /*values*/,
                            const Constants& constants) {
    context->save_for_backward({constants.sum});
    return at::empty({0}, at::kFloat);
  }
  static variable_list backward(AutogradContext* context, const variable_list& /*gradients*/) {
    return {context->get_saved_variables()[0], {}};
  }
};

class Asked : public torch::autograd::Function<Asked> {
 public:
  static variable_list forward(AutogradContext* context, const at::Tensor& query,
                               const at::Tensor& /*link*/, const Constants& constants) {
    const at::Tensor& values = constants.values;
    const std::int64_t n = values.size(0), longest = values.size(1), width = values.size(2);
    const at::Tensor shares = at::zeros({n, longest}, at::kFloat);
    const at::Tensor out = at::empty({n, width}, at::kFloat);
    const auto* const lengths = constants.lengths.data_ptr<std::int64_t>();
    at::parallel_for(0, n, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t r = begin; r < end; ++r) {
        const MatrixRows memory{numbers(values) + r * longest * width, size(width)};
        const MatrixRows share = rows_of(shares, r);
        simd_kernels().scores(rows_of(query, r), memory, share, 1, size(lengths[r]), size(width));
        simd_kernels().softmax(share[0], size(lengths[r]));
        simd_kernels().combine(
            {share[0], 0, 1, memory, rows_of(out, r), 1, size(width), size(lengths[r]), false});
      }
    });
    context->mark_non_differentiable({shares});
    context->save_for_backward({query, shares, values, constants.lengths, constants.sum});
    return {out, shares};
  }

  static variable_list backward(AutogradContext* context, const variable_list& gradients) {
    const variable_list saved = context->get_saved_variables();
    const at::Tensor &query = saved[0], &shares = saved[1], &values = saved[2], &sum = saved[4];
    const at::Tensor gradient = gradients[0].contiguous();
    const std::int64_t n = values.size(0), longest = values.size(1), width = values.size(2);
    const at::Tensor to_query = at::empty({n, width}, at::kFloat);
    const auto* const lengths = saved[3].data_ptr<std::int64_t>();
    at::parallel_for(0, n, 1, [&](std::int64_t begin, std::int64_t end) {
      std::vector<float> to_scores(size(longest)), both(size(2 * longest)), pair(size(2 * width));
      for (std::int64_t r = begin; r < end; ++r) {
        const std::size_t length = size(lengths[r]);
        const MatrixRows memory{numbers(values) + r * longest * width, size(width)};
        const MatrixRows from = rows_of(gradient, r), asked = rows_of(query, r);
        const float* share = rows_of(shares, r)[0];
        simd_kernels().scores(from, memory, {to_scores.data(), size(longest)}, 1, length,
                              size(width));
        simd_kernels().softmax_backward(share, to_scores.data(), length);
        simd_kernels().combine(
            {to_scores.data(), 0, 1, memory, rows_of(to_query, r), 1, size(width), length, false});
        if (!sum.defined()) continue;
        // A value's gradient: its score's part of the query, and its share of the gradient.
        for (std::size_t i = 0; i < length; ++i) {
          both[2 * i] = to_scores[i];
          both[2 * i + 1] = share[i];
        }
        std::copy_n(asked[0], width, pair.begin());
        std::copy_n(from[0], width, pair.begin() + width);
        simd_kernels().combine({both.data(),
                                2,
                                1,
                                {pair.data(), size(width)},
                                {numbers(sum) + r * longest * width, size(width)},
                                length,
                                size(width),
                                2,
                                true});
      }
    });
    return {to_query, {}, {}};
  }
};

}  // namespace

LstmRead read_lstm(const at::Tensor& x, const std::vector<std::int64_t>& lengths,
                   const LstmWeights& weights, bool backwards) {
  EN_CHECK(std::ranges::is_sorted(lengths, std::ranges::greater{}) && lengths.back() > 0);
  if (!x.device().is_cpu()) return read_lstm_by_parts(x, lengths, weights, backwards);
  const variable_list read = Lstm::apply(x, weights.input, weights.hidden, weights.input_bias,
                                         weights.hidden_bias, lengths, backwards);
  return {read[0], read[1], read[2]};
}

LstmRead read_lstm_by_parts(const at::Tensor& x, const std::vector<std::int64_t>& lengths,
                            const LstmWeights& weights, bool backwards) {
  const at::Tensor ends = at::tensor(lengths, at::kLong);
  // For each step the one that is read in its place: backwards from the row's end, behind it
  // itself.
  const at::Tensor step = at::arange(x.size(1), at::kLong).unsqueeze(0);
  const at::Tensor from = at::where(step.lt(ends.unsqueeze(1)), ends.unsqueeze(1) - 1 - step, step)
                              .to(x.device())
                              .unsqueeze(2);
  const auto turned = [&](const at::Tensor& rows) {
    return backwards ? rows.gather(1, from.expand({-1, -1, rows.size(2)})) : rows;
  };
  const auto [packed, sizes] = at::_pack_padded_sequence(turned(x), ends, true);
  const at::Tensor zeros = at::zeros({1, x.size(0), weights.hidden.size(1)}, x.options());
  const auto [outputs, hidden, cell] =
      at::lstm(packed, sizes, {zeros, zeros},
               {weights.input, weights.hidden, weights.input_bias, weights.hidden_bias}, true, 1,
               0.0, true, false);
  const auto [padded, lengths_again] =
      at::_pad_packed_sequence(outputs, sizes, true, 0.0, x.size(1));
  return {turned(padded), hidden[0], cell[0]};
}

std::pair<at::Tensor, at::Tensor> lstm_step(const at::Tensor& x, const at::Tensor& hidden,
                                            const at::Tensor& cell, const LstmWeights& weights) {
  const bool ours = x.device().is_cpu() && adds_in_place(weights.input) &&
                    adds_in_place(weights.hidden) && adds_in_place(weights.input_bias) &&
                    adds_in_place(weights.hidden_bias);
  if (!ours) {
    const auto [out, next] = at::lstm_cell(x, {hidden, cell}, weights.input, weights.hidden,
                                           weights.input_bias, weights.hidden_bias);
    return {out, next};
  }
  const variable_list read =
      LstmStep::apply(x.contiguous(), hidden.contiguous(), cell.contiguous(), weights.input,
                      weights.hidden, weights.input_bias, weights.hidden_bias);
  return {read[0], read[1]};
}

AttentionMemory::AttentionMemory(const at::Tensor& values, const at::Tensor& lengths)
    : values_(values.contiguous()), lengths_(lengths) {
  if (!values_.device().is_cpu() || !values_.requires_grad()) return;
  sum_ = at::zeros(values_.sizes(), at::kFloat);
  link_ = Link::apply(values_, Constants{{}, {}, sum_});
}

std::pair<at::Tensor, at::Tensor> AttentionMemory::attend(const at::Tensor& query) const {
  if (!values_.device().is_cpu()) return attend_by_parts(query);
  const at::Tensor link = link_.defined() ? link_ : at::empty({0}, at::kFloat);
  const variable_list found =
      Asked::apply(query.contiguous(), link, Constants{values_.detach(), lengths_, sum_});
  return {found[0], found[1]};
}

std::pair<at::Tensor, at::Tensor> AttentionMemory::attend_by_parts(const at::Tensor& query) const {
  const at::Tensor behind =
      at::arange(values_.size(1), lengths_.options()).unsqueeze(0).ge(lengths_.unsqueeze(1));
  const at::Tensor shares =
      at::softmax(at::bmm(values_, query.unsqueeze(2))
                      .squeeze(2)
                      .masked_fill(behind, -std::numeric_limits<double>::infinity()),
                  1);
  return {at::bmm(shares.unsqueeze(1), values_).squeeze(1), shares};
}

}  // namespace enfilade::neural::core
