#include "enfilade/models/network_config.h"

#include <fmt/format.h>
#include <array>

#include "enfilade/core/errors.h"

namespace enfilade::models {
namespace {

void require(bool holds, std::string_view field, double value, std::string_view allowed) {
  if (!holds) throw ArgumentError(fmt::format("network: {}: {}, {}", field, value, allowed));
}

}  // namespace

std::string_view to_string(Feedback feedback) noexcept {
  constexpr std::array<std::string_view, 3> kNames{"teacher", "sample", "argmax"};
  return kNames[static_cast<std::size_t>(feedback)];
}

void validate(const NetworkConfig& config) {
  const auto at_least = [](std::string_view field, std::size_t value, std::size_t least) {
    require(value >= least, field, static_cast<double>(value), fmt::format("at least {}", least));
  };
  at_least("vocabulary", config.vocabulary, 3);
  at_least("max_words", config.max_words, 1);
  at_least("word_embedding", config.word_embedding, 1);
  at_least("hidden", config.hidden, 1);
  at_least("action_embedding", config.action_embedding, 1);
  if (config.inputs.vision) at_least("features", config.features, 1);
  require(config.dropout >= 0 && config.dropout < 1, "dropout", config.dropout,
          "from 0 to below 1");
}

}  // namespace enfilade::models
