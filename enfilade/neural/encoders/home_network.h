/// \file  The small network of the encoder `home`: classes and distances of a picture's cells.
#pragma once
#include <ATen/core/Tensor.h>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/encoders/convolution.h"

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

}  // namespace enfilade::neural::encoders
