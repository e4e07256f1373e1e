/// \file  Parts of recurrent agents, each as one operation. PyTorch's backward pass through an
/// LSTM, and an attention at every step, copies the whole sequence once per step. Gradients flow
/// through the operations; those of gradients do not.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <utility>
#include <vector>

namespace enfilade::neural::core {

/// The arrays of one direction of an LSTM, in PyTorch's order of gates.
struct LstmWeights {
  at::Tensor input;                    ///< (4 hidden, in)
  at::Tensor hidden;                   ///< (4 hidden, hidden)
  at::Tensor input_bias, hidden_bias;  ///< (4 hidden)
};
/// Output of an LSTM for rows of steps.
struct LstmRead {
  at::Tensor outputs;       ///< (n, longest, hidden); zeros behind a row's end
  at::Tensor hidden, cell;  ///< (n, hidden) after the last step
};
/// Reads rows forwards, or backwards from their ends, from a state of zeros.
/// \param x (n, longest, in) \param lengths falling, from 1 to longest
LstmRead read_lstm(const at::Tensor& x, const std::vector<std::int64_t>& lengths,
                   const LstmWeights& weights, bool backwards);

/// The same of PyTorch's operations, on any device.
LstmRead read_lstm_by_parts(const at::Tensor& x, const std::vector<std::int64_t>& lengths,
                            const LstmWeights& weights, bool backwards);

/// One step of an LSTM. Gradients of weights that are leaves are added in place, as by linear().
/// \param x (n, in) \param hidden, cell (n, hidden) before it \return those after it
std::pair<at::Tensor, at::Tensor> lstm_step(const at::Tensor& x, const at::Tensor& hidden,
                                            const at::Tensor& cell, const LstmWeights& weights);

/// Sequences that are attended to many times, with one gradient for all of these.
class AttentionMemory {
 public:
  AttentionMemory() = default;
  /// \param values (n, longest, width) \param lengths (n) int64, from 1: later values are not used
  AttentionMemory(const at::Tensor& values, const at::Tensor& lengths);

  /// softmax(values query) values, over the own length. \param query (n, width)
  /// \return the sums (n, width), and the shares (n, longest), which have no gradient
  std::pair<at::Tensor, at::Tensor> attend(const at::Tensor& query) const;
  /// The same of PyTorch's operations, on any device.
  std::pair<at::Tensor, at::Tensor> attend_by_parts(const at::Tensor& query) const;

 private:
  at::Tensor values_, lengths_;
  at::Tensor link_;  // empty; what leads from each attention back to the values
  at::Tensor sum_;   // of the gradients of the values
};

}  // namespace enfilade::neural::core
