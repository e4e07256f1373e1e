/// \file  Actions and loss from six logits per row; a few numbers, so on the host.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/neural/seq2seq/network.h"

namespace enfilade::neural::seq2seq {

inline constexpr auto kLogits = static_cast<std::size_t>(kSixActionCount);  ///< numbers a row

/// One step of n rows.
struct Choices {
  std::span<double> logits;                    ///< (n, 6); loss() sets -inf where forward is closed
  std::span<const std::uint8_t> forward_open;  ///< (n)
  std::span<const std::int32_t> labels;        ///< (n), or empty without a teacher
};

/// \throws ArgumentError for a label out of range, or forward where that is closed
void check_labels(const Choices& step);

/// Sets logits to -inf where forward is closed. Returns the cross-entropy averaged over the rows
/// with a label (0 without labels).
/// \param gradient (n, 6) of the loss, or empty
double loss(const Choices& step, std::span<double> gradient);

/// Chooses actions, which are also the network's next inputs. With a teacher they are the labels,
/// and kIgnoreInput for rows without one. \pre loss() was called
void choose(const Choices& step, const RolloutOptions& options, std::size_t step_number,
            std::span<std::int32_t> actions);

}  // namespace enfilade::neural::seq2seq
