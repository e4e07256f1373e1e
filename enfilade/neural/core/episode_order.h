/// \file  The batch of episodes of each iteration of training.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace enfilade::neural::core {

/// Consecutive batches from repeated passes over n episodes, each pass shuffled. A batch may
/// contain the end of one pass and the beginning of the next. Pass p is shuffled by (seed, p). So a
/// batch is a function of the iteration, and a checkpoint need not store an order.
class EpisodeOrder {
 public:
  /// \pre episodes, batch_size > 0
  EpisodeOrder(std::size_t episodes, std::size_t batch_size, std::uint64_t seed);
  /// The batch of an iteration, counted from 0; valid until the next call.
  std::span<const std::size_t> batch(std::uint64_t iteration);

 private:
  void shuffle(std::uint64_t pass);

  std::uint64_t seed_;
  std::uint64_t pass_ = 0;  // that order_ is of
  std::vector<std::size_t> order_, batch_;
};

}  // namespace enfilade::neural::core
