/// \file  The arrays of DUET, and how to find its sizes in a file of weights.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/models/duet_config.h"
#include "enfilade/neural/core/weights.h"

namespace enfilade::neural::duet {

using models::duet_preset;
using models::DuetConfig;
using models::Fusion;

/// Numbers of a token's location: an angle feature of 4, and height, width and area of a box.
inline constexpr std::int64_t kLocation = 7;
/// Numbers of a position on the map: an angle feature of 4, two distances, hops.
inline constexpr std::int64_t kPosition = 7;

/// The sizes behind a file of weights, from its arrays' names and shapes. The number of heads is in
/// no shape: it is hidden / 64, as in all published networks, unless `heads` is given.
/// \throws InvalidInput naming every array that is needed for it and missing or of another rank
DuetConfig infer_config(const features::TensorFile& file, std::int64_t heads = 0);

/// The arrays of a network by their published names ("vln_bert.embeddings.LayerNorm.weight").
std::vector<core::ArraySpec> arrays_of(const DuetConfig& config);

}  // namespace enfilade::neural::duet
