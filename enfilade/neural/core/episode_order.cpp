#include "enfilade/neural/core/episode_order.h"

#include <numeric>

#include "enfilade/core/check.h"
#include "enfilade/core/rng.h"

namespace enfilade::neural::core {

EpisodeOrder::EpisodeOrder(std::size_t episodes, std::size_t batch_size, std::uint64_t seed)
    : seed_(seed), order_(episodes), batch_(batch_size) {
  EN_CHECK(episodes > 0);
  EN_CHECK(batch_size > 0);
  shuffle(0);
}

std::span<const std::size_t> EpisodeOrder::batch(std::uint64_t iteration) {
  const std::uint64_t first = iteration * batch_.size();
  for (std::size_t i = 0; i < batch_.size(); ++i) {
    const std::uint64_t pass = (first + i) / order_.size();
    if (pass != pass_) shuffle(pass);
    batch_[i] = order_[(first + i) % order_.size()];
  }
  return batch_;
}

void EpisodeOrder::shuffle(std::uint64_t pass) {
  pass_ = pass;
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  Rng(seed_, pass).shuffle(std::span(order_));
}

}  // namespace enfilade::neural::core
