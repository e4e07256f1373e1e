/// \file  A batch of instructions, packed for an LSTM without padding.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/neural/seq2seq/dropout.h"
#include "enfilade/neural/seq2seq/network.h"

namespace enfilade::neural::seq2seq {

/// Words are packed by position and, within a position, by decreasing length of their instruction.
/// So the instructions that continue are the first rows of the previous position.
struct Sentences {
  std::size_t size = 0;               ///< n instructions
  std::int64_t longest = 0;           ///< words
  std::vector<std::int64_t> lengths;  ///< (n) in the caller's order
  std::vector<std::int64_t> order;    ///< (n) the caller's row of each sorted row
  std::vector<std::int64_t> begin;    ///< (longest + 1) first packed word of a position
  std::vector<std::int64_t> words;    ///< packed: ids
  std::vector<MaskRow> masks;         ///< packed: (position, caller's row)
  std::vector<std::int64_t> places;   ///< packed: row * longest + position
  std::vector<std::int64_t>
      before;  ///< of packed words from position 1 on: the previous word of the row
  std::vector<std::int64_t> last;  ///< (n) in the caller's order: the row's last packed word

  std::int64_t rows(std::int64_t position) const {
    const auto p = static_cast<std::size_t>(position);
    return begin[p + 1] - begin[p];
  }
};

/// Packs a batch. Without language every instruction is just <EOS>, which gives the decoder no
/// information.
/// \throws ArgumentError for sizes that do not fit, an id outside the vocabulary, an instruction
/// without a word
Sentences lay_out(const InstructionBatch& batch, const models::NetworkConfig& config);

}  // namespace enfilade::neural::seq2seq
