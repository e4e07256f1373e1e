/// \file  Training of the network of home_network.h.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/encoders/home_network.h"
#include "enfilade/neural/encoders/home_pictures.h"

namespace enfilade::neural::encoders {

/// The classes and rooms that are frequent enough in the pictures to be learnt.
HomeWords words_of(const LabelledPictures& pictures);

/// Converts labels to indices of words: classes (n, c, rows, columns) uint8, rooms (n), -1:
/// unknown.
void number_labels(const HomeWords& words, LabelledPictures& pictures);

/// Converts uint8 (n, height, width, 3) to the input of HomeNetwork.
at::Tensor as_input(const at::Tensor& colours);

/// Parameters with gradients; each convolution of the trunk has a batch normalisation.
class HomeTraining {
 public:
  /// \param pictures numbered; their frequencies of classes weight the loss
  HomeTraining(const HomeWords& words, const LabelledPictures& pictures, std::uint64_t seed,
               c10::Device device);

  /// One step of Adam on these pictures, mirrored and recoloured at random. Returns the loss.
  double step(const LabelledPictures& pictures, const std::vector<std::int64_t>& which,
              double learning_rate);

  /// The current network with normalisations folded in. The caller adds the arrays "features.*".
  Weights folded() const;
  std::size_t parameters() const;

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
