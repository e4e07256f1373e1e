/// \file  The decoder: an LSTM over views and past actions, with attention to the instruction.
#pragma once
#include <ATen/ATen.h>

#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/neural/seq2seq/buffer.h"
#include "enfilade/neural/seq2seq/kernels.h"
#include "enfilade/neural/seq2seq/parameters.h"

namespace enfilade::neural::seq2seq {

/// Forward and backward pass of one rollout at a time. Each part of the forward pass takes a range
/// of steps. Values that do not depend on an action are computed for all steps in one product.
class ActionDecoder {
 public:
  ActionDecoder(const models::NetworkConfig& config, const Parameters& parameters,
                const Kernels& kernels);

  /// Begins a rollout of n rows and at most `steps` steps.
  /// \param keep values of all steps, for ranges and backward(), not only of the last
  void begin(std::int64_t n, std::int64_t steps, bool keep, const Dropout& dropout);
  at::Tensor start() const { return outputs_.select(0, 0); }  ///< (n, h), filled by the caller
  at::Tensor start_cells() const { return cells_.select(0, 0); }

  /// \param inputs (n) last actions \param features (n, features), undefined without vision
  void put_inputs(std::int64_t step, std::span<const std::int32_t> inputs,
                  const at::Tensor& features);
  /// Adds the inputs' part of the gates, for steps first .. first + count - 1.
  void multiply_inputs(std::int64_t first, std::int64_t count);
  void recur(std::int64_t step);
  /// Attention and logits (count * n, 6).
  at::Tensor attend(const Context& context, std::int64_t first, std::int64_t count);
  at::Tensor attention(std::int64_t step) const;  ///< (n, words)

  struct Gradients {
    at::Tensor context, start, cells;
  };
  /// Fills the decoder's gradients. \param logit_gradient (steps * n, 6) of all steps
  Gradients backward(const Context& context, const at::Tensor& logit_gradient);

 private:
  std::int64_t slot(std::int64_t step) const { return step % slots_; }
  at::Tensor flat(const at::Tensor& x, std::int64_t first, std::int64_t count) const {
    return x.narrow(0, slot(first), count).view({count * n_, x.size(2)});
  }
  at::Tensor input_weight() const;
  Masks masks(Site site, std::int64_t first, std::int64_t count) const;
  void attention_backward(const Context& context, std::int64_t steps,
                          const at::Tensor& hidden_gradient, const at::Tensor& both_gradient,
                          const at::Tensor& context_gradient);
  void gather_gradients(std::int64_t steps);

  const Parameters& parameters_;
  const Kernels& kernels_;
  std::int64_t hidden_, inputs_width_, embedding_;
  std::int64_t n_ = 0, slots_ = 0;
  Dropout dropout_;
  std::vector<MaskRow> rows_;         // (steps, n)
  std::vector<std::int64_t> inputs_;  // (steps, n) actions
  at::Tensor bias_;
  // (slots, n, ...); outputs_ and cells_ have a slot more, the start's. both_: mixed words beside
  // the dropped output.
  at::Tensor seen_, gates_, outputs_, cells_, both_, query_, weights_, attended_, logits_;
  Buffer seen_memory_, gates_memory_, outputs_memory_, cells_memory_, both_memory_, query_memory_;
  Buffer weights_memory_, attended_memory_, logits_memory_;
  Buffer hidden_gradient_memory_, both_gradient_memory_, query_gradient_memory_;
  Buffer context_gradient_memory_, next_memory_, cell_gradient_memory_, embedding_memory_;
};

}  // namespace enfilade::neural::seq2seq
