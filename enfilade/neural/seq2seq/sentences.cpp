#include "enfilade/neural/seq2seq/sentences.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "enfilade/core/errors.h"
#include "enfilade/models/instructions.h"

namespace enfilade::neural::seq2seq {
namespace {

void check(const InstructionBatch& batch, const models::NetworkConfig& config) {
  if (batch.tokens.size() != batch.size * config.max_words) {
    throw ArgumentError(fmt::format("instructions: {} ids for {} instructions of {} words",
                                    batch.tokens.size(), batch.size, config.max_words));
  }
  for (std::size_t i = 0; i < batch.tokens.size(); ++i) {
    if (batch.tokens[i] < config.vocabulary) continue;
    throw ArgumentError(fmt::format(
        "instructions: instruction {}, word {}: id {}, the vocabulary has {} words",
        i / config.max_words, i % config.max_words, batch.tokens[i], config.vocabulary));
  }
}

void set_lengths(const InstructionBatch& batch, const models::NetworkConfig& config,
                 Sentences& out) {
  for (std::size_t r = 0; r < batch.size; ++r) {
    const auto row = batch.tokens.subspan(r * config.max_words, config.max_words);
    const auto length =
        static_cast<std::int64_t>(config.inputs.language ? models::word_count(row) : 1);
    if (length == 0) {
      throw ArgumentError(fmt::format(
          "instructions: instruction {} begins with PAD: at least one word is needed", r));
    }
    out.lengths.push_back(length);
    out.longest = std::max(out.longest, length);
  }
}

}  // namespace

Sentences lay_out(const InstructionBatch& batch, const models::NetworkConfig& config) {
  check(batch, config);
  Sentences out;
  out.size = batch.size;
  set_lengths(batch, config, out);
  out.order.resize(batch.size);
  std::iota(out.order.begin(), out.order.end(), 0);
  const auto length = [&](std::int64_t row) { return out.lengths[static_cast<std::size_t>(row)]; };
  std::stable_sort(out.order.begin(), out.order.end(),
                   [&](std::int64_t a, std::int64_t b) { return length(a) > length(b); });
  out.last.resize(batch.size);
  out.begin.push_back(0);
  for (std::int64_t p = 0; p < out.longest; ++p) {
    for (std::size_t s = 0; s < out.order.size() && length(out.order[s]) > p; ++s) {
      const auto row = static_cast<std::size_t>(out.order[s]);
      const std::size_t place = row * config.max_words + static_cast<std::size_t>(p);
      out.last[row] = static_cast<std::int64_t>(out.words.size());
      out.words.push_back(config.inputs.language ? batch.tokens[place] : tasks::Vocabulary::kEnd);
      out.masks.push_back({static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(row)});
      out.places.push_back(out.order[s] * out.longest + p);
      if (p > 0) {
        const std::int64_t previous = out.begin[static_cast<std::size_t>(p - 1)];
        out.before.push_back(previous + static_cast<std::int64_t>(s));
      }
    }
    out.begin.push_back(static_cast<std::int64_t>(out.words.size()));
  }
  return out;
}

}  // namespace enfilade::neural::seq2seq
