/// \file  Matrix products, and the operations between them: fused loops on the CPU; plain ATen
/// elsewhere, and as the reference of the loops in tests.
#pragma once
#include <ATen/ATen.h>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "enfilade/neural/seq2seq/network.h"

namespace enfilade::neural::seq2seq {

/// Places in the network that use random numbers.
enum class DropoutSite : std::uint8_t { kWords, kContext, kActions, kFeatures, kAttention, kDraw };

/// A row of a batch at a word or step.
struct MaskRow {
  std::uint32_t step = 0;
  std::uint32_t row = 0;
};

/// Dropout of one rollout. A mask is a function of these numbers, its site, step and row. So the
/// backward pass computes it again, on any number of threads and any device.
struct RolloutDropout {
  std::uint64_t seed = 1;
  std::uint64_t stream = 0;
  double probability = 0;  ///< [0, 1); 0: nothing is dropped, nothing drawn

  bool on() const noexcept { return probability > 0; }
  float scale() const noexcept { return static_cast<float>(1 / (1 - probability)); }
};

constexpr std::size_t mask_words(std::size_t width) noexcept { return (width + 63) / 64; }

/// Bit i of the mask (bit i % 64 of word i / 64): 1 if element i is kept. One random bit per
/// element is used if the probability is 1/2, else 32.
/// \pre out.size() >= mask_words(width)
void draw_mask(const RolloutDropout& dropout, DropoutSite site, MaskRow at, std::size_t width,
               std::span<std::uint64_t> out) noexcept;

/// Uniform in [0, 1), for sampling the action of a row at a step.
double draw_uniform(std::uint64_t seed, std::uint64_t stream, MaskRow at) noexcept;

/// out = a b, all two-dimensional with one contiguous dimension; nothing is copied. All products of
/// the network are made here.
void multiply(const at::Tensor& a, const at::Tensor& b, const at::Tensor& out);
/// out += a b
void multiply_add(const at::Tensor& a, const at::Tensor& b, const at::Tensor& out);

/// A mask for each row of a tensor; `rows` empty: nothing is dropped.
struct Masks {
  RolloutDropout dropout;
  DropoutSite site = DropoutSite::kWords;
  std::span<const MaskRow> rows;

  bool on() const noexcept { return dropout.on() && !rows.empty(); }
};

/// Rows of a tensor, in order; empty: all.
using RowList = std::span<const std::int64_t>;

/// The encoded instructions that attention reads.
struct SentenceContext {
  at::Tensor words;                       ///< (n, words, h); undefined beyond the length
  std::span<const std::int64_t> lengths;  ///< (n)
};

/// All tensors have one type and device, and a contiguous last dimension. On the CPU nothing is
/// allocated that grows with the batch. Results do not depend on the number of threads.
class NetworkKernels {
 public:
  virtual ~NetworkKernels() = default;

  /// \param gates (n, 4 h) sums without bias, i f g o -> activations
  /// \param outputs,cells (n, h) written
  virtual void lstm_forward(const at::Tensor& gates, const at::Tensor& bias,
                            const at::Tensor& previous_cells, const at::Tensor& cells,
                            const at::Tensor& outputs) const = 0;
  /// \param gates activations -> gradient of the sums
  /// \param cell_gradient (n, h) of `cells` -> of `previous_cells`
  virtual void lstm_backward(const at::Tensor& gates, const at::Tensor& previous_cells,
                             const at::Tensor& cells, const at::Tensor& from_outputs,
                             const at::Tensor& from_next,
                             const at::Tensor& cell_gradient) const = 0;

  /// out[to[i]] = in[from[i]], dropped by mask i.
  virtual void move_rows(const at::Tensor& in, RowList from, const at::Tensor& out, RowList to,
                         const Masks& masks) const = 0;
  /// out[to[i]] += in[i], in the order of i.
  virtual void add_rows(const at::Tensor& in, const at::Tensor& out, RowList to) const = 0;
  virtual void column_sums(const at::Tensor& in, const at::Tensor& out) const = 0;
  virtual void add_bias(const at::Tensor& x, const at::Tensor& bias) const = 0;  ///< to each row
  virtual void clear(const at::Tensor& x) const = 0;  ///< zeros \pre x is contiguous

  virtual void tanh(const at::Tensor& x) const = 0;
  virtual void tanh_backward(const at::Tensor& y, const at::Tensor& gradient) const = 0;

  /// weights = softmax(words . query) over a row's words, 0 past them; mixed = weights . words.
  /// \param query,mixed (steps, n, h); weights (steps, n, words)
  virtual void attend(const SentenceContext& context, const at::Tensor& query,
                      const at::Tensor& weights, const at::Tensor& mixed) const = 0;
  /// \param words_gradient (n, words, h); undefined beyond the length
  virtual void attend_backward(const SentenceContext& context, const at::Tensor& query,
                               const at::Tensor& weights, const at::Tensor& mixed_gradient,
                               const at::Tensor& query_gradient,
                               const at::Tensor& words_gradient) const = 0;

  /// All flat and of one length. \param updates this one included
  virtual void adam(const models::AdamConfig& config, std::uint64_t updates,
                    const at::Tensor& weights, const at::Tensor& gradients, const at::Tensor& first,
                    const at::Tensor& second) const = 0;
  virtual bool all_finite(const at::Tensor& flat) const = 0;
};

/// For float on the CPU.
std::unique_ptr<NetworkKernels> make_cpu_kernels();
/// For any type and device.
std::unique_ptr<NetworkKernels> make_aten_kernels();

}  // namespace enfilade::neural::seq2seq
