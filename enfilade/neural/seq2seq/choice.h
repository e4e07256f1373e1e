/// \file  From six logits to an action and a loss: a few numbers a row, so on the host.
#pragma once
#include <cstdint>
#include <span>

#include "enfilade/neural/network.h"

namespace enfilade::neural::seq2seq {

/// One step of n rows.
struct Choices {
  std::span<double> logits;                    ///< (n, 6); -inf is put where forward is closed
  std::span<const std::uint8_t> forward_open;  ///< (n)
  std::span<const std::int32_t> labels;        ///< (n), or empty without a teacher
};

/// \throws ArgumentError for a label that is none, or is forward where that is closed
void check_labels(const Choices& step);

/// Puts -inf where forward is closed; returns the cross-entropy averaged over the rows that count
/// (0 if none does). `gradient`, if not empty: (n, 6) of that loss.
double loss(const Choices& step, std::span<double> gradient);

/// \pre loss() was called. Teacher: the labels, kIgnoreInput for those that count no more. The
/// actions are what the network is fed next, too.
void choose(const Choices& step, const RolloutOptions& options, std::size_t step_number,
            std::span<std::int32_t> actions);

}  // namespace enfilade::neural::seq2seq
