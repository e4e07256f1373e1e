/// \file  Evaluation of a trained home network.
#pragma once
#include "enfilade/neural/encoders/home_network.h"
#include "enfilade/neural/encoders/home_pictures.h"
#include "enfilade/neural/pretrain.h"

namespace enfilade::neural::encoders {

/// \param pictures numbered (number_labels())
HomeScore score(const HomeNetwork& network, const LabelledPictures& pictures);

/// Area under the precision-recall curve (ties in the order given); NaN if no truth is 1.
/// \pre scores.size() == truths.size()
double average_precision(std::span<const float> scores, std::span<const std::uint8_t> truths);

}  // namespace enfilade::neural::encoders
