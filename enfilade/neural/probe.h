/// \file  How much of what views show can be read linearly from their features.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/features/feature_set.h"
#include "enfilade/scan/panorama_set.h"

namespace enfilade::neural {

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
