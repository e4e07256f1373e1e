#include "enfilade/models/network_config.h"

#include <fmt/format.h>
#include <initializer_list>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"

namespace enfilade::models {
namespace {

constexpr double kMostSize = 1U << 24U;

// Checks sizes that are from 1 on. \throws ArgumentError naming the first field out of range
void check_sizes(std::initializer_list<std::pair<const char*, std::size_t>> sizes) {
  for (const auto& [name, size] : sizes) {
    check_range(name, static_cast<double>(size), 1, kMostSize);
  }
}

// Checks what PanoramicConfig and SpeakerConfig both have, likewise.
template <class Config>
void check_directions(const Config& config) {
  constexpr double kMostDropout = 0.99;
  check_range("image", static_cast<double>(config.image), 0, kMostSize);
  if (config.bidirectional && config.hidden % 2 != 0) {
    throw ArgumentError(fmt::format("hidden: {}, not even, as two directions need", config.hidden));
  }
  if (config.angle % 4 != 0) {
    throw ArgumentError(fmt::format("angle: {}, not a multiple of 4", config.angle));
  }
  check_range("dropout", config.dropout, 0, kMostDropout);
  check_range("feature_dropout", config.feature_dropout, 0, kMostDropout);
}

}  // namespace

void validate(const NetworkConfig& config) {
  const auto require = [](bool holds, std::string_view field, double value,
                          std::string_view allowed) {
    if (!holds) throw ArgumentError(fmt::format("network: {}: {}, {}", field, value, allowed));
  };
  const auto at_least = [&](std::string_view field, std::size_t value, std::size_t least) {
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

void validate(const PanoramicConfig& config) {
  check_sizes({{"vocabulary", config.vocabulary},
               {"word_embedding", config.word_embedding},
               {"action_embedding", config.action_embedding},
               {"hidden", config.hidden},
               {"angle", config.angle}});
  check_directions(config);
}

void validate(const SpeakerConfig& config) {
  check_sizes({{"vocabulary", config.vocabulary},
               {"word_embedding", config.word_embedding},
               {"hidden", config.hidden},
               {"angle", config.angle}});
  check_directions(config);
}

DuetConfig duet_preset(std::string_view name) {
  DuetConfig config;
  if (name == "duet") return config;
  if (name != "duet-s") {
    throw ArgumentError(fmt::format("{} is no size of DUET; there are duet, duet-s", quote(name)));
  }
  config.hidden = 128;
  config.heads = 4;
  config.feed_forward = config.panorama_feed_forward = 512;
  config.text_layers = 2;
  config.panorama_layers = 1;
  config.cross_layers = 2;
  return config;
}

void validate(const DuetConfig& c) {
  const auto require = [](bool possible, std::string_view name, std::int64_t value,
                          std::string_view allowed) {
    if (possible) return;
    throw ArgumentError(fmt::format("DUET: {} is {}; allowed: {}", name, value, allowed));
  };
  const auto at_least = [&](std::string_view name, std::int64_t value, std::int64_t least) {
    require(value >= least, name, value, fmt::format("{} or more", least));
  };
  at_least("hidden", c.hidden, 1);
  require(c.heads >= 1 && c.hidden % c.heads == 0, "heads", c.heads,
          fmt::format("a divisor of hidden, {}", c.hidden));
  at_least("feed_forward", c.feed_forward, 1);
  at_least("panorama_feed_forward", c.panorama_feed_forward, 1);
  at_least("text_layers", c.text_layers, 0);
  at_least("panorama_layers", c.panorama_layers, 0);
  at_least("cross_layers", c.cross_layers, 0);
  at_least("vocabulary", c.vocabulary, 1);
  at_least("positions", c.positions, 1);
  at_least("token_types", c.token_types, 2);
  at_least("image", c.image, 0);
  at_least("object", c.object, 0);
  require(c.max_words >= 1 && c.max_words <= c.positions, "max_words", c.max_words,
          fmt::format("1 to positions, {}", c.positions));
  require(c.max_actions >= 1 && c.max_actions <= c.steps, "max_actions", c.max_actions,
          fmt::format("1 to steps, {}", c.steps));
}

void validate(const Seq2SeqCeConfig& config) {
  check_sizes({{"word_embedding", config.word_embedding},
               {"sentence", config.sentence},
               {"picture", config.picture},
               {"depth", config.depth},
               {"action_embedding", config.action_embedding},
               {"hidden", config.hidden},
               {"sets", config.sets},
               {"set_walks", config.set_walks},
               {"epochs", config.epochs}});
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
