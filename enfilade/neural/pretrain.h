/// \file  Training of the small encoder for model homes, for machines without ImageNet's weights.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/scan/panorama_set.h"

namespace enfilade::neural {

/// What the encoder of model homes learns from, and for how long.
struct PretrainConfig {
  std::vector<std::string> training;  ///< scans to learn from; their panoramas need all labels
  std::vector<std::string> unseen;    ///< scans to be tried on in the end; may be none
  /// Letter of the room (Matterport3D's region types) that a viewpoint stands in; '-' or an empty
  /// function: not known.
  std::function<char(const std::string& scan, const std::string& viewpoint)> room;
  std::size_t pictures = 12'000;  ///< to train on, about; at most 36 a viewpoint
  std::size_t epochs = 3;         ///< times that each is seen
  std::uint64_t seed = 1;
  std::string device = "cpu";  ///< "cpu", "cuda", "cuda:1"
  int threads = 0;  ///< that draw; 0: all cores. Training runs on libtorch's: set_threads()
};

/// How well pictures are understood that the network was not trained on.
struct HomeScore {
  std::size_t pictures = 0;
  /// Of "does this third of the picture show more than 2 % of the class", by
  /// PretrainReport::classes: average precision, 0 to 1; NaN where it is shown fewer than 20 times.
  std::vector<double> average_precision;
  double mean_average_precision = 0;  ///< over classes that have one
  double chance = 0;                  ///< what guessing gets
  double rooms = 0;                   ///< share of pictures whose room is named right
  double distance_error = 0;          ///< mean |ln(said / true)| over cells
};

/// What the encoder has learnt, and how well it does in homes that it has not seen.
struct PretrainReport {
  std::vector<std::int64_t> classes;  ///< mpcat40, ascending
  std::string rooms;                  ///< letters
  std::size_t pictures = 0, steps = 0, parameters = 0;
  double drawing_seconds = 0, training_seconds = 0;
  double loss = 0;   ///< mean of the last tenth of the steps
  HomeScore seen;    ///< at viewpoints of the training scans that were kept apart, every tenth
  HomeScore unseen;  ///< in scans of config.unseen
};

/// Called after each step of pretraining.
using PretrainProgress = std::function<void(std::size_t step, std::size_t steps, double loss)>;

/// Draws pictures in the training scans (headings and elevations at random), with what the renderer
/// says is to be seen: classes and distances, cell by cell; trains a network to say it from colour
/// alone; writes it to `file` for make_encoder(). The same seed and numbers of threads give the
/// same bytes. \throws LookupError for panoramas without depth or classes; ArgumentError for no
/// training scan, 0 pictures or epochs; FileError, InvalidInput of the panoramas; as make_encoder()
/// for the device
PretrainReport pretrain_home_encoder(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                                     const PretrainConfig& config,
                                     const std::filesystem::path& file,
                                     const PretrainProgress& progress = {});

}  // namespace enfilade::neural
