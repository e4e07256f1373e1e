/// \file  The order of recorded trajectories in training, and batches of them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/models/seq2seq_ce_config.h"
#include "enfilade/neural/continuous/episode_file.h"
#include "enfilade/neural/continuous/network.h"

namespace enfilade::neural::continuous {

/// Position of an update in a training.
struct Place {
  std::size_t sets = 1;   ///< that there are then
  std::size_t epoch = 0;  ///< over these
  std::size_t batch = 0;  ///< of this pass
  /// Whether it is the first after the last set was gathered.
  bool first() const noexcept { return epoch == 0 && batch == 0; }
};
/// \pre update < models::updates_of(config, batch)
Place place_of(const models::Seq2SeqCeConfig& config, std::size_t batch, std::uint64_t update);

/// The batches of one pass over trajectories, each once; the last batch may be smaller.
/// Trajectories of a batch are about as long as each other, and longer ones come first. Of 16
/// batches' trajectories, which are drawn, those of like length go together.
/// \param lengths steps by trajectory
std::vector<std::vector<std::size_t>> pass_over(std::span<const std::size_t> lengths,
                                                std::size_t batch, std::uint64_t seed,
                                                std::uint64_t pass);

/// Walks side by side, and what the teacher said at each of their steps.
struct EpisodeBatch {
  Steps steps;
  at::Tensor teacher;                 ///< (rows) int64
  std::vector<std::size_t> episodes;  ///< per trajectory
};
/// \pre one walk at least, longer ones first; each has a step
EpisodeBatch side_by_side(std::span<const EpisodeView> walks, const Sizes& sizes);

}  // namespace enfilade::neural::continuous
