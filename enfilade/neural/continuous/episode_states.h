/// \file  Walking step by step: the network's memory of each episode of a batch.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <span>
#include <vector>

#include "enfilade/models/instruction_words.h"
#include "enfilade/models/network_config.h"
#include "enfilade/neural/continuous/network.h"
#include "enfilade/neural/continuous/sight.h"

namespace enfilade::neural::continuous {

/// The ids of an instruction as the network reads it. An agent that uses no language reads the ids
/// of its two ends alone.
std::vector<std::int64_t> read_text(const models::InstructionWords& words, std::string_view text,
                                    const models::NetworkConfig& config);

/// (n, features) numbers of stored pictures; those of an agent that does not see are zeros.
at::Tensor picture_numbers(std::span<const std::uint16_t> halves, std::int64_t n,
                           const Sizes& sizes);
/// (n, kDepthSize) likewise, from 0 to 1.
at::Tensor depth_numbers(std::span<const std::uint8_t> bytes, std::int64_t n);

/// By slot: the sentence's state, the GRU's, and the last action. No gradients. One thread at a
/// time.
class EpisodeStates {
 public:
  /// \param network outlives *this
  explicit EpisodeStates(const CeNetwork& network) : network_(network) {}

  /// A new episode begins in a slot. \param instruction its ids
  void start(std::size_t slot, const std::vector<std::int64_t>& instruction);
  /// Goes one step on in some slots. \param seen there, in their order; empty: nothing
  /// \return (slots, kChoices) probabilities of the choices
  at::Tensor step(std::span<const std::size_t> slots, const Seen& seen);
  /// The likeliest choices instead of their probabilities.
  std::vector<std::int64_t> likeliest(std::span<const std::size_t> slots, const Seen& seen);
  /// Sets the last action of a slot. \pre it has begun
  void tell(std::size_t slot, std::int64_t choice) { previous_[slot] = 1 + choice; }
  /// The input for the last action: kNoAction or 1 + choice.
  std::int64_t previous(std::size_t slot) const { return previous_[slot]; }

 private:
  const CeNetwork& network_;
  at::Tensor sentences_, states_;  // (slots, sentence), (slots, hidden)
  std::vector<std::int64_t> previous_;
};

}  // namespace enfilade::neural::continuous
