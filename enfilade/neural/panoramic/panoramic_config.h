/// \file  The arrays of the panoramic LSTM agent.
#pragma once
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/models/panoramic_config.h"
#include "enfilade/neural/core/weights.h"

namespace enfilade::neural::panoramic {

using models::PanoramicConfig;
using models::Subout;

/// The arrays of encoder, decoder and critic, by the names of the published code.
std::vector<core::ArraySpec> array_specs(const PanoramicConfig& config);

/// The sizes of a file of weights, from the shapes of its arrays. Dropout and `subout` are those of
/// `defaults`, as no shape gives them.
/// \throws InvalidInput naming each array that is missing or of another number of sides
PanoramicConfig config_of(const features::TensorFile& file, const PanoramicConfig& defaults);

}  // namespace enfilade::neural::panoramic
