/// \file  Common parts of EnvDrop's listener and speaker.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
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
void add_lstm(std::vector<core::ArraySpec>& specs, const std::string& prefix,
              const std::string& suffix, std::int64_t input, std::int64_t hidden);

/// Initial values of an array, drawn by the seed and the array's name, as PyTorch's modules have
/// them. They are uniform within +-`bound`. A table of words is normal, with zeros in the row of
/// padding.
at::Tensor first_values(const core::ArraySpec& spec, bool words, double bound, std::uint64_t seed);

/// The array of that name. \throws LookupError
const at::Tensor& weight_of(const core::Weights& weights, std::string_view name);

/// Output of an LSTM for rows of steps.
struct LstmOutput {
  at::Tensor outputs;        ///< (n, longest, directions * hidden); zeros behind a row's end
  at::Tensor hidden, cells;  ///< (directions, n, hidden) after the last step
};
/// Reads rows in one or both directions, none behind its end.
/// \param x (n, longest, input) \param lengths (n) int64, falling, from 1
/// \param name "encoder.lstm": of the arrays `name`.weight_ih_l0 and so on
LstmOutput read_rows(const core::Weights& weights, const std::string& name, bool bidirectional,
                     const at::Tensor& x, const at::Tensor& lengths);

/// Views with dropped numbers of their pictures; directions stay.
/// \param features (..., image + angle)
at::Tensor drop_pictures(const at::Tensor& features, std::size_t image, double rate,
                         core::Dropout& dropout);

/// Finds sizes in the matrices of a file.
class MatrixSides {
 public:
  /// \param network the network of the arrays, for messages: "EnvDrop's speaker"
  MatrixSides(const features::TensorFile& file, std::string_view network)
      : file_(file), network_(network) {}

  /// A side of a matrix; 0 after a fault. \pre at < 2
  std::size_t side(std::string_view name, std::size_t at);
  /// The rest of `feature` numbers, which side() found in the array `name`, beside those of an
  /// angle.
  /// \throws InvalidInput for faults so far, or if there are fewer than `angle`
  std::size_t image(std::string_view name, std::size_t feature, std::size_t angle);
  /// \throws InvalidInput if a network cannot have the sizes
  template <class Config>
  void validate_all(const Config& config) const {
    try {
      validate(config);
    } catch (const ArgumentError& wrong) {
      refuse(file_.path().string(), "", "wrong-shape", wrong.what());
    }
  }

 private:
  const features::TensorFile& file_;
  std::string_view network_;
  std::vector<Diagnostic> faults_;
};

}  // namespace enfilade::neural::core
