/// \file  The environment of the sequence-to-sequence network: six actions, a batch of episodes.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/agents/six_actions.h"

namespace enfilade::neural::seq2seq {

/// The network's outputs are the six actions, in their order.
using agents::kSixActionCount;
using agents::SixAction;
/// Two inputs that are not actions: the one before the first action, and that of an episode that is
/// over. So the network has 8 inputs.
inline constexpr std::int32_t kStartInput = 6;
inline constexpr std::int32_t kIgnoreInput = 7;
/// A teacher's label for an episode that no longer adds to the loss.
inline constexpr std::int32_t kIgnoreLabel = -1;

/// Observation of n episodes before an action. The memory belongs to the network.
struct EnvironmentView {
  std::span<float> features;             ///< (n, dimensions) of the view each agent has
  std::span<std::uint8_t> forward_open;  ///< (n) 1 if there is a viewpoint forward
  /// (n) 0..5 or kIgnoreLabel; filled only on request.
  std::span<std::int32_t> labels;
};

/// A batch of episodes in lock-step. The network calls observe() and step(), alternating.
class Environment {
 public:
  virtual ~Environment() = default;
  virtual std::size_t size() const = 0;        ///< n
  virtual std::size_t dimensions() const = 0;  ///< of the features
  virtual bool has_teacher() const = 0;        ///< whether it can fill `labels`
  /// The present observation of every episode. \param out its spans are filled
  virtual void observe(const EnvironmentView& out) = 0;
  /// One action per episode; that of an ended episode is ignored, except with AfterEnd::kWalksOn.
  /// False when every episode is over.
  virtual bool step(std::span<const std::int32_t> actions) = 0;
  /// (n) 1 if the episode is over; valid until the next step().
  virtual std::span<const std::uint8_t> ended() const = 0;
};

}  // namespace enfilade::neural::seq2seq
