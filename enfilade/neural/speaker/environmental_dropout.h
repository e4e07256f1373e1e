/// \file  Environmental dropout: the same columns of pictures' features are missing all over a
/// building (Tan, Yu, Bansal 2019).
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/neural/panoramic/panoramic_episode.h"

namespace enfilade::neural::speaker {

using panoramic::ImageSource;

/// Over what the same columns are missing.
enum class SameEnvironment : std::uint8_t {
  kBatch,  ///< everywhere, as published: a batch is one environment
  kScan,   ///< in a building; others have their own
};

/// Rate and random numbers of the dropout.
struct EnvironmentalDropoutOptions {
  double rate = 0.3;  ///< share of columns that become 0, [0, 1); the others are scaled up
  SameEnvironment same = SameEnvironment::kBatch;
  std::uint64_t seed = 1, stream = 0;  ///< of the columns: another stream, another environment
};

/// The factors of the columns: 0, or 1 / (1 - rate). The same options and scan give the same ones;
/// with SameEnvironment::kBatch the scan is of no account.
/// \throws ArgumentError for a rate outside [0, 1)
std::vector<float> column_factors(const EnvironmentalDropoutOptions& options, std::size_t columns,
                                  ScanIndex scan);

/// Pictures with columns missing, the same for all views and viewpoints of an environment, so also
/// for candidates. For networks that then drop no numbers of their own: a speaker's
/// FeaturesDropped::kBefore, a listener's StepInput::dropped. Keeps `images`, and the factors of
/// each scan after its first use. One thread at a time.
/// \throws ArgumentError for a rate outside [0, 1)
ImageSource drop_environment(ImageSource images, const EnvironmentalDropoutOptions& options);

}  // namespace enfilade::neural::speaker
