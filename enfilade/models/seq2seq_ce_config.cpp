#include "enfilade/models/seq2seq_ce_config.h"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::models {

void validate(const Seq2SeqCeConfig& config) {
  constexpr std::size_t kMost = std::size_t{1} << 24U;
  const std::array<std::pair<const char*, std::size_t>, 9> sizes{
      {{"word_embedding", config.word_embedding},
       {"sentence", config.sentence},
       {"picture", config.picture},
       {"depth", config.depth},
       {"action_embedding", config.action_embedding},
       {"hidden", config.hidden},
       {"sets", config.sets},
       {"set_walks", config.set_walks},
       {"epochs", config.epochs}}};
  for (const auto& [name, size] : sizes) {
    if (size >= 1 && size <= kMost) continue;
    throw ArgumentError(fmt::format("{}: {}, not from 1 to {}", name, size, kMost));
  }
  check_range("inflection", config.inflection, 0.001, 1000);
  check_range("teacher_share", config.teacher_share, 0, 1);
}

std::size_t updates_of(const Seq2SeqCeConfig& config, std::size_t batch) {
  std::size_t updates = 0;
  for (std::size_t sets = 1; sets <= config.sets; ++sets) {
    updates += config.epochs * ((sets * config.set_walks + batch - 1) / batch);
  }
  return updates;
}

}  // namespace enfilade::models
