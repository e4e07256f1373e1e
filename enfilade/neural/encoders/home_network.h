/// \file  The small network of the encoder `home`: classes and distances of a picture's cells; its
/// training and its scores.
#pragma once
#include <ATen/core/Tensor.h>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/encoders/convolution.h"
#include "enfilade/neural/encoders/home_pictures.h"
#include "enfilade/neural/pretrain.h"

namespace enfilade::neural::encoders {

/// Size of its pictures, and the grid of cells that it predicts.
inline constexpr std::uint32_t kHomeWidth = 128, kHomeHeight = 96;
inline constexpr std::int64_t kHomeStride = 8;  ///< pixels per cell
inline constexpr std::int64_t kHomeColumns = kHomeWidth / kHomeStride;
inline constexpr std::int64_t kHomeRows = kHomeHeight / kHomeStride;

/// A convolution of the trunk.
struct HomeLayer {
  std::int64_t in, out, size, stride, dilation;
};
/// The total stride is 8; the dilations make the last layer's receptive field as high as the
/// picture.
inline constexpr std::array<HomeLayer, 6> kHomeLayers{{{3, 32, 5, 2, 1},
                                                       {32, 64, 3, 2, 1},
                                                       {64, 96, 3, 2, 1},
                                                       {96, 128, 3, 1, 1},
                                                       {128, 128, 3, 1, 2},
                                                       {128, 128, 3, 1, 4}}};
inline constexpr std::int64_t kHomeChannels = kHomeLayers.back().out;

/// The classes and rooms that the network predicts: those of its training homes.
struct HomeWords {
  std::vector<std::int64_t> classes;  ///< mpcat40, ascending; all others count as the first
  std::string rooms;                  ///< letters of Matterport3D's room types, ascending
};

/// \pre c = words.classes.size(), r = words.rooms.size()
struct HomeOutputs {
  at::Tensor classes;    ///< (n, c, rows, columns) logits
  at::Tensor distances;  ///< (n, 1, rows, columns) natural logarithm of metres along the ray
  at::Tensor rooms;      ///< (n, r) logits of the camera's room
};

/// Normalisation of pictures.
inline constexpr float kHomeMean = 0.5F, kHomeDeviation = 0.25F;

/// Vertical thirds of the picture, as ranges of columns.
inline constexpr std::int64_t kThirds = 3;
inline constexpr std::array<std::int64_t, kThirds + 1> kThirdColumns{0, 5, 11, kHomeColumns};
/// (n, k, rows, columns) -> (n, k, 3): the mean over each third.
at::Tensor pool_thirds(const at::Tensor& cells);

/// Features (n, 3 c + 3 + r): for each third the square root of each class's share, and the mean
/// distance; then the rooms' probabilities. The root, as an object's share is the square of its
/// size.
at::Tensor describe(const HomeOutputs& outputs);

/// Names and shapes of the arrays of a file.
std::vector<core::ArraySpec> home_arrays(const HomeWords& words);

/// The network after its training. Runs on one device.
class HomeNetwork {
 public:
  HomeNetwork(const core::Weights& weights, c10::Device device);
  /// \param pictures (n, 3, kHomeHeight, kHomeWidth), of any device
  HomeOutputs run(const at::Tensor& pictures) const;

 private:
  c10::Device device_;
  std::vector<Convolution> trunk_;
  Convolution classes_, distances_;
  at::Tensor rooms_weight_, rooms_bias_;
};

/// Writes a file: weights and, as metadata, words.
void write_home_network(const std::filesystem::path& file, const core::Weights& weights,
                        const HomeWords& words);
/// The content of such a file.
struct HomeFile {
  core::Weights weights;
  HomeWords words;
};
/// \throws FileError; InvalidInput for another file, or if arrays are missing
HomeFile read_home_network(const std::filesystem::path& file);

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

/// \param pictures numbered (number_labels())
HomeScore score(const HomeNetwork& network, const LabelledPictures& pictures);

/// Area under the precision-recall curve (ties in the order given); NaN if no truth is 1.
/// \pre scores.size() == truths.size()
double average_precision(std::span<const float> scores, std::span<const std::uint8_t> truths);

}  // namespace enfilade::neural::encoders
