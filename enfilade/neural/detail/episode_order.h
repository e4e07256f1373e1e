/// \file  Which episodes an iteration of training takes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace enfilade::neural::detail {

/// Batches one after another from an endless row of shuffled passes over n episodes, so that a
/// batch may hold the end of one pass and the begin of the next. Pass p is shuffled by (seed, p),
/// which makes a batch a function of the iteration alone: a checkpoint has no order to keep.
class EpisodeOrder {
 public:
  /// \pre episodes, batch_size > 0
  EpisodeOrder(std::size_t episodes, std::size_t batch_size, std::uint64_t seed);
  /// The batch of an iteration, counted from 0; valid until the next call.
  std::span<const std::size_t> batch(std::uint64_t iteration);

 private:
  void shuffle(std::uint64_t pass);

  std::uint64_t seed_;
  std::uint64_t pass_;  // that order_ is of
  std::vector<std::size_t> order_, batch_;
};

}  // namespace enfilade::neural::detail
