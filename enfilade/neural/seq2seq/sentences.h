/// \file  A batch of instructions laid out for an LSTM that does no work on padding.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/neural/network.h"
#include "enfilade/neural/seq2seq/dropout.h"

namespace enfilade::neural::seq2seq {

/// Words are packed position by position, and within a position by the length of their
/// instruction, longest first: those that go on are the first rows of the position before.
struct Sentences {
  std::size_t size = 0;               ///< n instructions
  std::int64_t longest = 0;           ///< words
  std::vector<std::int64_t> lengths;  ///< (n) in the caller's order
  std::vector<std::int64_t> order;    ///< (n) the caller's row of each sorted one
  std::vector<std::int64_t> begin;    ///< (longest + 1) first packed word of a position
  std::vector<std::int64_t> words;    ///< packed: ids
  std::vector<MaskRow> masks;         ///< packed: (position, caller's row)
  std::vector<std::int64_t> places;   ///< packed: row * longest + position
  std::vector<std::int64_t> before;   ///< packed words from position 1 on: the same row's last one
  std::vector<std::int64_t> last;     ///< (n) in the caller's order: the packed last word

  std::int64_t rows(std::int64_t position) const {
    const auto p = static_cast<std::size_t>(position);
    return begin[p + 1] - begin[p];
  }
};

/// Without language every instruction is a lone <EOS>: the weights keep their shapes, and the
/// decoder's start and memory say nothing. \throws ArgumentError for sizes that do not fit, an id
/// outside the vocabulary, an instruction without a word
Sentences lay_out(const InstructionBatch& batch, const models::NetworkConfig& config);

}  // namespace enfilade::neural::seq2seq
