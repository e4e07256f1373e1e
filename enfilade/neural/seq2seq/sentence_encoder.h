/// \file  The encoder: word embeddings and an LSTM over packed instructions.
#pragma once
#include <ATen/ATen.h>

#include "enfilade/neural/seq2seq/buffer.h"
#include "enfilade/neural/seq2seq/kernels.h"
#include "enfilade/neural/seq2seq/parameters.h"
#include "enfilade/neural/seq2seq/sentences.h"

namespace enfilade::neural::seq2seq {

/// Forward and backward pass of one batch at a time; keeps what the backward pass needs.
class SentenceEncoder {
 public:
  SentenceEncoder(const Parameters& parameters, const Kernels& kernels)
      : parameters_(parameters), kernels_(kernels) {}

  /// \param sentences must live until backward() \param start,cells (n, h) written: the
  /// decoder's initial state. The context is valid until the next call.
  Context forward(const Sentences& sentences, const Dropout& dropout, const at::Tensor& start,
                  const at::Tensor& cells);

  /// \param context_gradient (n, longest, h) \param start_gradient,cell_gradient (n, h), of what
  /// forward() wrote; start_gradient is overwritten. Fills the encoder's gradients.
  void backward(const Sentences& sentences, const Dropout& dropout,
                const at::Tensor& context_gradient, const at::Tensor& start,
                const at::Tensor& start_gradient, const at::Tensor& cell_gradient);

 private:
  void begin_backward(const Sentences& sentences, const at::Tensor& start,
                      const at::Tensor& start_gradient, const at::Tensor& cell_gradient);
  void steps_backward(const Sentences& sentences);
  void gather_gradients(const Sentences& sentences, const Dropout& dropout);
  at::Tensor previous_cells(const Sentences& sentences, std::int64_t position) const;

  const Parameters& parameters_;
  const Kernels& kernels_;
  // Packed, except last_, from_next_ and cell_gradient_: (n, h), the latter two sorted by length.
  at::Tensor words_, gates_, outputs_, cells_, last_, zeros_;
  at::Tensor output_gradient_, from_next_, cell_gradient_;
  Buffer words_memory_, gates_memory_, outputs_memory_, cells_memory_, last_memory_;
  Buffer context_memory_, gradient_memory_, next_memory_, cell_memory_, before_memory_;
};

}  // namespace enfilade::neural::seq2seq
