/// \file  Pretraining of `home`, the small image encoder for synthetic homes.
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

/// Data and length of a pretraining.
struct PretrainConfig {
  std::vector<std::string> training;  ///< scans to train on; their panoramas need depth and classes
  std::vector<std::string> unseen;    ///< scans to evaluate on in the end; may be none
  /// Letter of the room (Matterport3D's region types) of a viewpoint; '-' or an empty function:
  /// unknown.
  std::function<char(const std::string& scan, const std::string& viewpoint)> room;
  std::size_t pictures = 12'000;  ///< of training, about; at most 36 per viewpoint
  std::size_t epochs = 3;         ///< passes over the pictures
  std::uint64_t seed = 1;
  std::string device = "cpu";  ///< "cpu", "cuda", "cuda:1"
  int threads = 0;  ///< of rendering; 0: all cores. Training runs on libtorch's: set_threads()
};

/// Scores on pictures that the network was not trained on.
struct HomeScore {
  std::size_t pictures = 0;
  /// Average precision, 0 to 1, by PretrainReport::classes, of the prediction that more than 2 % of
  /// a third of the picture are of the class. NaN for classes that occur fewer than 20 times.
  std::vector<double> average_precision;
  double mean_average_precision = 0;  ///< over the classes that are not NaN
  double chance = 0;                  ///< that of random guesses
  double rooms = 0;                   ///< share of pictures with the right room
  double distance_error = 0;          ///< mean |ln(predicted / true)| over cells
};

/// The result of pretrain_home_encoder().
struct PretrainReport {
  std::vector<std::int64_t> classes;  ///< mpcat40, ascending
  std::string rooms;                  ///< letters
  std::size_t pictures = 0, steps = 0, parameters = 0;
  double drawing_seconds = 0, training_seconds = 0;
  double loss = 0;   ///< mean of the last tenth of the steps
  HomeScore seen;    ///< at every tenth viewpoint of the training scans, held out
  HomeScore unseen;  ///< in scans of config.unseen
};

/// Called after each step of pretraining.
using PretrainProgress = std::function<void(std::size_t step, std::size_t steps, double loss)>;

/// Trains a network to predict classes and distances of pictures' cells from colour alone, and
/// writes it to `file` for make_encoder(). Pictures are rendered in the training scans at random
/// headings and elevations. The same seed and numbers of threads give the same bytes.
/// \throws LookupError for panoramas without depth or classes
/// \throws ArgumentError for no training scan, 0 pictures or epochs
/// \throws FileError, InvalidInput of the panoramas; as make_encoder() for the device
PretrainReport pretrain_home_encoder(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                                     const PretrainConfig& config,
                                     const std::filesystem::path& file,
                                     const PretrainProgress& progress = {});

}  // namespace enfilade::neural
