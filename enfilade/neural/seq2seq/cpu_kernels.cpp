#include <algorithm>
#include <atomic>
#include <cmath>

#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"
#include "enfilade/neural/core/simd_kernels.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/seq2seq/kernels.h"

namespace enfilade::neural::seq2seq {
namespace {

using core::AdamStep;
using core::LstmBackward;
using core::LstmForward;
using core::LstmRows;
using core::MatrixRows;
using core::simd_kernels;
using core::SimdKernels;

// Work on fewer numbers is done before another thread has started.
constexpr std::size_t kWorthAThread = 262144;

std::size_t extent(const at::Tensor& x, std::int64_t dimension) {
  return static_cast<std::size_t>(x.size(dimension));
}

// The last two dimensions; callers loop over those before them.
MatrixRows rows_of(const at::Tensor& x) {
  return {x.data_ptr<float>(), static_cast<std::size_t>(x.stride(-2))};
}

// body(begin, end) over rows of `width` numbers each, a part a thread.
template <class Body>
void for_rows(std::size_t rows, std::size_t width, const Body& body) {
  const int chosen = rows * width < kWorthAThread ? 1 : core::kernel_threads();
  const int threads = threads_or_all(chosen);
  const auto parts = static_cast<std::size_t>(threads);
  parallel_for(rows, (rows + parts - 1) / parts, threads, body);
}

// body(row) for each row of a matrix.
template <class Body>
void for_each_row(const at::Tensor& x, const Body& body) {
  for_rows(extent(x, 0), extent(x, 1), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

LstmRows lstm_rows(const at::Tensor& gates, const at::Tensor& previous, const at::Tensor& cells) {
  return {rows_of(gates), rows_of(previous), rows_of(cells), extent(cells, 1)};
}

// Does not use libtorch's own threads: idle OpenMP threads spin, on the cores that the BLAS's
// threads need next.
class CpuKernels final : public NetworkKernels {
 public:
  void lstm_forward(const at::Tensor& gates, const at::Tensor& bias,
                    const at::Tensor& previous_cells, const at::Tensor& cells,
                    const at::Tensor& outputs) const override {
    const LstmForward step{lstm_rows(gates, previous_cells, cells), bias.data_ptr<float>(),
                           rows_of(outputs)};
    for_rows(extent(gates, 0), extent(gates, 1),
             [&](std::size_t begin, std::size_t end) { simd_.lstm_forward(step, begin, end); });
  }

  void lstm_backward(const at::Tensor& gates, const at::Tensor& previous_cells,
                     const at::Tensor& cells, const at::Tensor& from_outputs,
                     const at::Tensor& from_next, const at::Tensor& cell_gradient) const override {
    const LstmBackward step{lstm_rows(gates, previous_cells, cells), rows_of(from_outputs),
                            rows_of(from_next), rows_of(cell_gradient)};
    for_rows(extent(gates, 0), extent(gates, 1),
             [&](std::size_t begin, std::size_t end) { simd_.lstm_backward(step, begin, end); });
  }

  void move_rows(const at::Tensor& in, RowList from, const at::Tensor& out, RowList to,
                 const Masks& masks) const override {
    const std::size_t width = extent(out, 1);
    const std::size_t rows =
        !from.empty() ? from.size() : (!to.empty() ? to.size() : extent(in, 0));
    const MatrixRows source = rows_of(in), target = rows_of(out);
    for_rows(rows, width, [&](std::size_t begin, std::size_t end) {
      std::vector<std::uint64_t> kept(mask_words(width));
      for (std::size_t i = begin; i < end; ++i) {
        const float* a = source[from.empty() ? i : static_cast<std::size_t>(from[i])];
        float* b = target[to.empty() ? i : static_cast<std::size_t>(to[i])];
        if (masks.on()) {
          draw_mask(masks.dropout, masks.site, masks.rows[i], width, kept);
          simd_.drop(a, b, width, kept.data(), masks.dropout.scale());
        } else if (a != b) {
          std::copy_n(a, width, b);
        }
      }
    });
  }

  void add_rows(const at::Tensor& in, const at::Tensor& out, RowList to) const override {
    const MatrixRows source = rows_of(in), target = rows_of(out);
    // Threads divide the columns, so the order of each sum is always the same.
    for_rows(extent(in, 1), to.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = 0; i < to.size(); ++i) {
        simd_.add_row(source[i] + begin, target[static_cast<std::size_t>(to[i])] + begin,
                      end - begin);
      }
    });
  }

  void column_sums(const at::Tensor& in, const at::Tensor& out) const override {
    const MatrixRows source = rows_of(in);
    float* sums = out.data_ptr<float>();
    const std::size_t rows = extent(in, 0);
    for_rows(extent(in, 1), rows, [&](std::size_t begin, std::size_t end) {
      std::fill(sums + begin, sums + end, 0.0F);
      for (std::size_t i = 0; i < rows; ++i) {
        simd_.add_row(source[i] + begin, sums + begin, end - begin);
      }
    });
  }

  void add_bias(const at::Tensor& x, const at::Tensor& bias) const override {
    const MatrixRows rows = rows_of(x);
    const float* in = bias.data_ptr<float>();
    for_each_row(x, [&](std::size_t i) { simd_.add_row(in, rows[i], extent(x, 1)); });
  }

  void clear(const at::Tensor& x) const override {
    float* data = x.data_ptr<float>();
    for_rows(static_cast<std::size_t>(x.numel()), 1, [&](std::size_t begin, std::size_t end) {
      std::fill(data + begin, data + end, 0.0F);
    });
  }

  void tanh(const at::Tensor& x) const override {
    const MatrixRows rows = rows_of(x);
    for_each_row(x, [&](std::size_t i) { simd_.tanh(rows[i], extent(x, 1)); });
  }

  void tanh_backward(const at::Tensor& y, const at::Tensor& gradient) const override {
    const MatrixRows values = rows_of(y), gradients = rows_of(gradient);
    for_each_row(
        y, [&](std::size_t i) { simd_.tanh_backward(values[i], gradients[i], extent(y, 1)); });
  }

  void attend(const SentenceContext& context, const at::Tensor& query, const at::Tensor& weights,
              const at::Tensor& mixed) const override {
    const std::size_t steps = extent(query, 0), h = extent(query, 2), words = extent(weights, 2);
    for_rows(context.lengths.size(), words * h, [&](std::size_t begin, std::size_t end) {
      for (std::size_t r = begin; r < end; ++r) {
        const auto length = static_cast<std::size_t>(context.lengths[r]);
        const MatrixRows memory = words_of(context.words, r);
        const MatrixRows weight = steps_of(weights, r);
        simd_.scores(steps_of(query, r), memory, weight, steps, length, h);
        for (std::size_t t = 0; t < steps; ++t) {
          simd_.softmax(weight[t], length);
          std::fill(weight[t] + length, weight[t] + words, 0.0F);
        }
        simd_.combine(
            {weight.data, weight.stride, 1, memory, steps_of(mixed, r), steps, h, length, false});
      }
    });
  }

  void attend_backward(const SentenceContext& context, const at::Tensor& query,
                       const at::Tensor& weights, const at::Tensor& mixed_gradient,
                       const at::Tensor& query_gradient,
                       const at::Tensor& words_gradient) const override {
    const std::size_t steps = extent(query, 0), h = extent(query, 2), words = extent(weights, 2);
    for_rows(context.lengths.size(), words * h, [&](std::size_t begin, std::size_t end) {
      std::vector<float> scores(steps * words);
      const MatrixRows score{scores.data(), words};
      for (std::size_t r = begin; r < end; ++r) {
        const auto length = static_cast<std::size_t>(context.lengths[r]);
        const MatrixRows memory = words_of(context.words, r), weight = steps_of(weights, r);
        const MatrixRows mixed = steps_of(mixed_gradient, r), queries = steps_of(query, r);
        const MatrixRows out = words_of(words_gradient, r);
        simd_.scores(mixed, memory, score, steps, length, h);
        for (std::size_t t = 0; t < steps; ++t) {
          simd_.softmax_backward(weight[t], score[t], length);
        }
        simd_.combine(
            {score.data, words, 1, memory, steps_of(query_gradient, r), steps, h, length, false});
        simd_.combine({weight.data, 1, weight.stride, mixed, out, length, h, steps, false});
        simd_.combine({score.data, 1, words, queries, out, length, h, steps, true});
      }
    });
  }

  void adam(const models::AdamConfig& config, std::uint64_t updates, const at::Tensor& weights,
            const at::Tensor& gradients, const at::Tensor& first,
            const at::Tensor& second) const override {
    const auto n = static_cast<double>(updates);
    const AdamStep step{weights.data_ptr<float>(),
                        gradients.data_ptr<float>(),
                        first.data_ptr<float>(),
                        second.data_ptr<float>(),
                        static_cast<float>(config.beta1),
                        static_cast<float>(config.beta2),
                        static_cast<float>(config.epsilon),
                        static_cast<float>(config.weight_decay),
                        static_cast<float>(config.learning_rate / (1 - std::pow(config.beta1, n))),
                        static_cast<float>(1 / std::sqrt(1 - std::pow(config.beta2, n)))};
    for_rows(extent(weights, 0), 1,
             [&](std::size_t begin, std::size_t end) { simd_.adam(step, begin, end); });
  }

  bool all_finite(const at::Tensor& flat) const override {
    const float* x = flat.data_ptr<float>();
    std::atomic<bool> finite = true;
    for_rows(extent(flat, 0), 1, [&](std::size_t begin, std::size_t end) {
      if (!simd_.all_finite(x + begin, end - begin)) finite = false;
    });
    return finite;
  }

 private:
  // One episode's rows of (n, words, h), and of (steps, n, x).
  static MatrixRows words_of(const at::Tensor& x, std::size_t r) {
    return {x.data_ptr<float>() + r * static_cast<std::size_t>(x.stride(0)),
            static_cast<std::size_t>(x.stride(1))};
  }
  static MatrixRows steps_of(const at::Tensor& x, std::size_t r) {
    return {x.data_ptr<float>() + r * static_cast<std::size_t>(x.stride(1)),
            static_cast<std::size_t>(x.stride(0))};
  }

  const SimdKernels& simd_ = simd_kernels();
};

// Steps are far below 2^24.
std::uint64_t substream(DropoutSite site, MaskRow at) noexcept {
  return (std::uint64_t{static_cast<std::uint8_t>(site)} << 56U) | (std::uint64_t{at.step} << 32U) |
         at.row;
}

}  // namespace

std::unique_ptr<NetworkKernels> make_cpu_kernels() { return std::make_unique<CpuKernels>(); }

void draw_mask(const RolloutDropout& dropout, DropoutSite site, MaskRow at, std::size_t width,
               std::span<std::uint64_t> out) noexcept {
  Rng rng(dropout.seed, dropout.stream, substream(site, at));
  const std::size_t words = mask_words(width);
  if (dropout.probability == 0.5) {
    for (std::size_t w = 0; w < words; ++w) out[w] = rng.next();
    return;
  }
  const auto dropped = static_cast<std::uint64_t>(dropout.probability * 0x1p32);
  for (std::size_t w = 0; w < words; ++w) {
    std::uint64_t bits = 0;
    for (unsigned i = 0; i < 64; i += 2) {
      const std::uint64_t two = rng.next();
      bits |= std::uint64_t{(two & 0xffffffffU) >= dropped} << i;
      bits |= std::uint64_t{(two >> 32U) >= dropped} << (i + 1);
    }
    out[w] = bits;
  }
}

double draw_uniform(std::uint64_t seed, std::uint64_t stream, MaskRow at) noexcept {
  return Rng(seed, stream, substream(DropoutSite::kDraw, at)).uniform();
}

}  // namespace enfilade::neural::seq2seq
