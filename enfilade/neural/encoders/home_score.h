/// \file  How well a trained home network says what is to be seen.
#pragma once
#include "enfilade/neural/encoders/home_network.h"
#include "enfilade/neural/encoders/home_pictures.h"
#include "enfilade/neural/pretrain.h"

namespace enfilade::neural::encoders {

/// \param pictures numbered (number_labels())
HomeScore score(const HomeNetwork& network, const LabelledPictures& pictures);

/// Area under precision over recall, each hit counted when it comes (ties in the order given).
/// \pre scores.size() == truths.size() Returns NaN without a single true one.
double average_precision(std::span<const float> scores, std::span<const std::uint8_t> truths);

}  // namespace enfilade::neural::encoders
