/// \file  Common parts of networks with LSTMs: EnvDrop's listener and speaker, the continuous
/// agent.
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/core/dropout.h"
#include "enfilade/neural/core/weights.h"

namespace enfilade::neural::core {

/// The arrays of one direction of an LSTM. \param prefix of their names, "encoder.lstm."
/// \param suffix likewise, "_l0"
void add_lstm(std::vector<ArraySpec>& specs, const std::string& prefix, const std::string& suffix,
              std::int64_t input, std::int64_t hidden);

/// The arrays of an attention of `hidden` numbers to vectors of `context` numbers; it has no bias.
void add_attention(std::vector<ArraySpec>& specs, const std::string& name, std::int64_t hidden,
                   std::int64_t context);

/// Weights by name on one device, and dropout. Autograd follows every call, unless a guard is set.
/// In float32; inputs may be on any device. One thread at a time.
class LstmNetwork {
 public:
  /// By the published names. Handles to the network's own memory.
  const Weights& weights() const noexcept { return weights_; }
  c10::Device device() const noexcept { return device_; }
  /// \throws LookupError for an unknown name
  const at::Tensor& weight(std::string_view name) const;
  /// Turns dropout on, drawing from this seed. No value: off, as at first.
  void set_dropout(std::optional<std::uint64_t> seed);

 protected:
  /// What PyTorch draws an array by: uniform numbers within +-1 / sqrt(of this). 0: a table of
  /// words, which is normal, with zeros in the row of padding.
  using FanOf = std::function<std::int64_t(const ArraySpec&)>;
  /// Random weights as PyTorch's modules begin with, by the seed and the arrays' names.
  LstmNetwork(std::span<const ArraySpec> arrays, const FanOf& fan_of, std::uint64_t seed,
              c10::Device device);
  /// Those of a file. \throws as read_weights()
  LstmNetwork(std::span<const ArraySpec> arrays, const features::TensorFile& file,
              c10::Device device, bool (*ignored)(std::string_view) = nothing);

  at::Tensor drop(const at::Tensor& x, double rate);
  /// Views with dropped numbers of their pictures; directions stay.
  /// \param features (..., image + angle)
  at::Tensor drop_pictures(const at::Tensor& features, std::size_t image, double rate);

 private:
  Weights weights_;
  c10::Device device_;
  std::optional<Dropout> dropout_;
};

/// Output of an LSTM for rows of steps.
struct LstmOutput {
  at::Tensor outputs;        ///< (n, longest, directions * hidden); zeros behind a row's end
  at::Tensor hidden, cells;  ///< (directions, n, hidden) after the last step
};
/// Reads rows in one or both directions, none behind its end.
/// \param x (n, longest, input) \param lengths (n) int64, falling, from 1
/// \param name "encoder.lstm": of the arrays `name`.weight_ih_l0 and so on
LstmOutput read_rows(const Weights& weights, const std::string& name, bool bidirectional,
                     const at::Tensor& x, const at::Tensor& lengths);

}  // namespace enfilade::neural::core
