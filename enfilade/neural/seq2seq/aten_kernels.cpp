#include <algorithm>
#include <cmath>

#include "enfilade/neural/seq2seq/kernels.h"

namespace enfilade::neural::seq2seq {
namespace {

at::Tensor indices(RowList rows, const at::Tensor& like) {
  const auto options = at::TensorOptions().dtype(at::kLong);
  at::Tensor result = at::empty({static_cast<std::int64_t>(rows.size())}, options);
  std::copy(rows.begin(), rows.end(), result.data_ptr<std::int64_t>());
  return result.to(like.device());
}

// (rows, width), 0 or the scale.
at::Tensor mask_tensor(const Masks& masks, std::int64_t width, const at::Tensor& like) {
  const auto rows = static_cast<std::int64_t>(masks.rows.size());
  at::Tensor result = at::zeros({rows, width}, at::TensorOptions().dtype(at::kFloat));
  std::vector<std::uint64_t> kept(mask_words(static_cast<std::size_t>(width)));
  float* out = result.data_ptr<float>();
  for (const MaskRow row : masks.rows) {
    draw_mask(masks.dropout, masks.site, row, static_cast<std::size_t>(width), kept);
    for (std::int64_t i = 0; i < width; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if ((kept[at / 64] >> (at % 64) & 1U) != 0) out[i] = masks.dropout.scale();
    }
    out += width;
  }
  return result.to(like.options());
}

// (n, words): where there is no word
at::Tensor past_lengths(const SentenceContext& context) {
  const at::Tensor length = indices(context.lengths, context.words).unsqueeze(1);
  return at::arange(context.words.size(1), length.options()).unsqueeze(0).ge(length);
}

// With 0 past the lengths, where memory may hold anything: 0 times NaN is NaN.
at::Tensor words_of(const SentenceContext& context) {
  return context.words.masked_fill(past_lengths(context).unsqueeze(2), 0);
}

class AtenKernels final : public NetworkKernels {
 public:
  void lstm_forward(const at::Tensor& gates, const at::Tensor& bias,
                    const at::Tensor& previous_cells, const at::Tensor& cells,
                    const at::Tensor& outputs) const override {
    const std::int64_t h = cells.size(1);
    gates.add_(bias);
    gates.narrow(1, 0, 2 * h).sigmoid_();
    gates.narrow(1, 2 * h, h).tanh_();
    gates.narrow(1, 3 * h, h).sigmoid_();
    const auto gate = gates.chunk(4, 1);
    cells.copy_(gate[1] * previous_cells + gate[0] * gate[2]);
    outputs.copy_(gate[3] * cells.tanh());
  }

  void lstm_backward(const at::Tensor& gates, const at::Tensor& previous_cells,
                     const at::Tensor& cells, const at::Tensor& from_outputs,
                     const at::Tensor& from_next, const at::Tensor& cell_gradient) const override {
    const auto gate = gates.chunk(4, 1);
    const at::Tensor in = gate[0].clone(), forget = gate[1].clone();
    const at::Tensor candidate = gate[2].clone(), out = gate[3].clone();
    const at::Tensor squashed = cells.tanh(), output = from_outputs + from_next;
    const at::Tensor cell = cell_gradient + output * out * (1 - squashed * squashed);
    gate[0].copy_(cell * candidate * in * (1 - in));
    gate[1].copy_(cell * previous_cells * forget * (1 - forget));
    gate[2].copy_(cell * in * (1 - candidate * candidate));
    gate[3].copy_(output * squashed * out * (1 - out));
    cell_gradient.copy_(cell * forget);
  }

  void move_rows(const at::Tensor& in, RowList from, const at::Tensor& out, RowList to,
                 const Masks& masks) const override {
    at::Tensor moved = from.empty() ? in : in.index_select(0, indices(from, in));
    if (masks.on()) moved = moved * mask_tensor(masks, out.size(1), out);
    if (to.empty()) {
      out.copy_(moved);
    } else {
      out.index_copy_(0, indices(to, out), moved);
    }
  }

  void add_rows(const at::Tensor& in, const at::Tensor& out, RowList to) const override {
    // index_add_ on CUDA adds in any order; this one sorts first.
    out.index_put_({indices(to, out)}, in, true);
  }
  void column_sums(const at::Tensor& in, const at::Tensor& out) const override {
    out.copy_(in.sum(0));
  }
  void add_bias(const at::Tensor& x, const at::Tensor& bias) const override { x.add_(bias); }
  void clear(const at::Tensor& x) const override { x.zero_(); }

  void tanh(const at::Tensor& x) const override { x.tanh_(); }
  void tanh_backward(const at::Tensor& y, const at::Tensor& gradient) const override {
    gradient.mul_(1 - y * y);
  }

  void attend(const SentenceContext& context, const at::Tensor& query, const at::Tensor& weights,
              const at::Tensor& mixed) const override {
    const at::Tensor words = words_of(context);
    const at::Tensor scores = at::bmm(query.transpose(0, 1), words.transpose(1, 2))
                                  .masked_fill(past_lengths(context).unsqueeze(1), -INFINITY);
    const at::Tensor softmax = scores.softmax(2);  // (n, steps, words)
    weights.copy_(softmax.transpose(0, 1));
    mixed.copy_(at::bmm(softmax, words).transpose(0, 1));
  }

  void attend_backward(const SentenceContext& context, const at::Tensor& query,
                       const at::Tensor& weights, const at::Tensor& mixed_gradient,
                       const at::Tensor& query_gradient,
                       const at::Tensor& words_gradient) const override {
    const at::Tensor weight = weights.transpose(0, 1), mixed = mixed_gradient.transpose(0, 1);
    const at::Tensor words = words_of(context);
    const at::Tensor from_mixed = at::bmm(mixed, words.transpose(1, 2));
    const at::Tensor score = weight * (from_mixed - (weight * from_mixed).sum(2, /*keepdim=*/true));
    query_gradient.copy_(at::bmm(score, words).transpose(0, 1));
    words_gradient.copy_(at::bmm(weight.transpose(1, 2), mixed) +
                         at::bmm(score.transpose(1, 2), query.transpose(0, 1)));
  }

  void adam(const models::AdamConfig& config, std::uint64_t updates, const at::Tensor& weights,
            const at::Tensor& gradients, const at::Tensor& first,
            const at::Tensor& second) const override {
    const auto n = static_cast<double>(updates);
    const at::Tensor gradient = gradients + weights * config.weight_decay;
    first.mul_(config.beta1).add_(gradient, 1 - config.beta1);
    second.mul_(config.beta2).addcmul_(gradient, gradient, 1 - config.beta2);
    const at::Tensor divisor =
        second.sqrt().div_(std::sqrt(1 - std::pow(config.beta2, n))).add_(config.epsilon);
    weights.addcdiv_(first, divisor, -config.learning_rate / (1 - std::pow(config.beta1, n)));
  }
  bool all_finite(const at::Tensor& flat) const override {
    return flat.isfinite().all().item<bool>();
  }
};

}  // namespace

void multiply(const at::Tensor& a, const at::Tensor& b, const at::Tensor& out) {
  at::Tensor target = out;
  at::mm_out(target, a, b);
}

void multiply_add(const at::Tensor& a, const at::Tensor& b, const at::Tensor& out) {
  out.addmm_(a, b);
}

std::unique_ptr<NetworkKernels> make_aten_kernels() { return std::make_unique<AtenKernels>(); }

}  // namespace enfilade::neural::seq2seq
