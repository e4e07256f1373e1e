/// \file  What the sequence-to-sequence network walks in: six actions, a batch of episodes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/agents/six_actions.h"

namespace enfilade::neural {

/// The network's outputs are the six actions, in their order.
using agents::kSixActions;
using agents::SixAction;
/// Inputs that are no actions, so the network has 8 inputs: what comes before the first action, and
/// what is fed for an episode that is over.
inline constexpr std::int32_t kStartInput = 6;
inline constexpr std::int32_t kIgnoreInput = 7;
/// A teacher's label for an episode that adds no loss any more.
inline constexpr std::int32_t kIgnoreLabel = -1;

/// What n episodes show before an action; the memory is the network's.
struct EnvironmentView {
  std::span<float> features;             ///< (n, dimensions) of the view each agent has
  std::span<std::uint8_t> forward_open;  ///< (n) 1 if there is a viewpoint to go forward to
  /// (n) 0..5 or kIgnoreLabel; filled only if asked for.
  std::span<std::int32_t> labels;
};

/// A batch of episodes in lock-step. The network asks observe(), then calls step(), in turn.
class Environment {
 public:
  virtual ~Environment() = default;
  virtual std::size_t size() const = 0;        ///< n
  virtual std::size_t dimensions() const = 0;  ///< of the features
  virtual bool has_teacher() const = 0;        ///< can it fill `labels`
  /// What the network sees of every episode now. \param out its spans are filled
  virtual void observe(const EnvironmentView& out) = 0;
  /// One action an episode (ended ones' are not looked at unless the quirk of the recipe asks for
  /// it). False when every episode is over.
  virtual bool step(std::span<const std::int32_t> actions) = 0;
  /// (n) 1 if the episode is over; valid until the next step().
  virtual std::span<const std::uint8_t> ended() const = 0;
};

}  // namespace enfilade::neural
