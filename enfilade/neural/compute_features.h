/// \file  Computing features: every view of every viewpoint through an encoder, into a file.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/encoder.h"
#include "enfilade/scan/panorama_set.h"

namespace enfilade::neural {

/// Encoder, views and shard of a run.
struct FeatureJob {
  EncoderConfig encoder;
  Shard shard;            ///< of the viewpoints
  std::size_t batch = 4;  ///< pictures per call of the encoder, at least 1
  features::DType type = features::DType::kFloat32;  ///< of the file: kFloat32 or kFloat16
  int threads = 0;  ///< of rendering; 0: all cores. The encoder runs on libtorch's: set_threads()
};

/// Result of compute_features().
struct FeatureReport {
  std::size_t viewpoints = 0;        ///< of the shard, in the file now
  std::size_t resumed = 0;           ///< of them, those computed by an earlier run that was stopped
  std::vector<std::string> without;  ///< scans without pictures at any included viewpoint
  double rendering_seconds = 0;      ///< decoding of panoramas included; on a card, only the asking
  double encoding_seconds = 0;
};

/// Renders the 36 discretized views (render::discrete_views) of each included viewpoint that has
/// pictures, in the order of the set's scans. Runs the encoder on them, and writes its output with
/// a FeatureWriter; a stopped run is continued. The values do not depend on shards and `threads`,
/// and on `batch` and libtorch's threads in the last bits only. An encoder on a card has its
/// pictures rendered there (render::Backend::kCuda, the same bytes).
/// \param progress counts viewpoints
/// \throws as make_encoder(), FeatureWriter and the panoramas' sources
/// \throws ArgumentError for a batch of 0, a shard out of range, or if there is no viewpoint at all
FeatureReport compute_features(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                               const FeatureJob& job, const std::filesystem::path& file,
                               const Progress& progress = {});

}  // namespace enfilade::neural
