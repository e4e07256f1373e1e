/// \file  The small image encoder `home` for synthetic homes: its pretraining, and a linear probe
/// of features.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/features/feature_set.h"
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

/// Training and test data of a probe.
struct ProbeConfig {
  std::vector<std::string> training;  ///< scans to fit on; their panoramas need depth and classes
  std::vector<std::string> unseen;    ///< other scans, to be scored in
  /// Letter of the room (Matterport3D's region types) of a viewpoint; '-' or an empty function:
  /// unknown.
  std::function<char(const std::string& scan, const std::string& viewpoint)> room;
  std::size_t viewpoints = 300;  ///< of each of the two at most, evenly from all of them
  int threads = 0;               ///< of rendering the labels; 0: all cores
};

/// Scores in the unseen scans. NaN without anything to score, for example if no room has a label.
struct ProbeReport {
  std::size_t dimensions = 0;            ///< of the features
  std::size_t training = 0, unseen = 0;  ///< viewpoints, of 36 views each
  std::size_t classes = 0;               ///< that occur often enough to be scored
  double view_precision = 0;             ///< mean average precision of "the view shows it"
  double view_chance = 0;                ///< that of random guesses
  double third_precision = 0;            ///< likewise of "the left (middle, right) third shows it"
  double third_chance = 0;               ///< that of random guesses
  double room = 0;                       ///< share of views with the right name of their
                                         ///< viewpoint's room
  double viewpoint_room = 0;             ///< share of viewpoints, by the sum over their views
  double room_chance = 0;  ///< share of the room that is most frequent where the probe was fitted
  double distance_error = 0;   ///< mean |ln(predicted / true)| of the thirds' mean ln distances
  double distance_chance = 0;  ///< the same of the means where the probe was fitted
};

/// Fits ridge regressions from the features of single views, scaled to deviations of 1, to the
/// renderer's labels of these views in the training scans. Scores them in the unseen ones. The
/// penalty of each kind of label is the one of five with the best result on a fifth of the training
/// scans. A class is present if it covers more than 2 % of the pixels; classes that occur fewer
/// than 20 times on either side are not scored. Deterministic, up to rounding with the number of
/// threads.
/// \throws ArgumentError for no training or unseen scan with pictures, 0 viewpoints, or features of
/// another number of views than 36
/// \throws LookupError naming a viewpoint without features, and for panoramas without depth or
/// classes
/// \throws as FeatureSet::copy_views() and the panoramas
ProbeReport probe_features(const features::FeatureSet& features,
                           const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                           const ProbeConfig& config);

}  // namespace enfilade::neural
