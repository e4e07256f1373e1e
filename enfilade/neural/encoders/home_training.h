/// \file  Training of the network of home_network.h.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/encoders/home_network.h"
#include "enfilade/neural/encoders/home_pictures.h"

namespace enfilade::neural::encoders {

/// The classes that cover enough of the pictures to be learnt, and the rooms that occur in them.
HomeWords words_of(const LabelledPictures& pictures);

/// Converts labels to indices into `words`: classes become (n, c, rows, columns) uint8, rooms (n),
/// where -1 is a room that is not in `words`.
void number_labels(const HomeWords& words, LabelledPictures& pictures);

/// Converts uint8 (n, height, width, 3) to the input of HomeNetwork.
at::Tensor as_input(const at::Tensor& colours);

/// The network while it is trained: parameters with gradients, and a batch normalisation after each
/// convolution of the trunk.
class HomeTraining {
 public:
  /// \param pictures with numbered labels; how often each class occurs in them weights the loss
  HomeTraining(const HomeWords& words, const LabelledPictures& pictures, std::uint64_t seed,
               c10::Device device);

  /// One step of Adam on these pictures, mirrored and recoloured at random. Returns the loss.
  double step(const LabelledPictures& pictures, const std::vector<std::int64_t>& which,
              double learning_rate);

  /// The current weights, the normalisations folded into the convolutions. The caller adds the
  /// arrays "features.*".
  core::Weights folded() const;
  std::size_t parameters() const;  ///< how many numbers are trained

 private:
  struct TrunkLayer {
    at::Tensor weight, scale, shift, mean, variance;
  };
  struct Head {
    at::Tensor weight, bias;
  };
  struct Moments {
    at::Tensor first, second;
  };

  at::Tensor parameter(at::Tensor values);
  Head make_head(const std::vector<std::int64_t>& shape);
  HomeOutputs run(at::Tensor x);
  at::Tensor loss_of(const HomeOutputs& outputs, const LabelledPictures& truth) const;
  void adam(double learning_rate);

  c10::Device device_;
  Rng rng_;
  std::vector<TrunkLayer> trunk_;
  Head classes_, distances_, rooms_;
  at::Tensor class_weights_;  // (c, 1, 1)
  std::vector<at::Tensor> parameters_;
  std::vector<Moments> moments_;
  std::int64_t steps_ = 0;
};

}  // namespace enfilade::neural::encoders
