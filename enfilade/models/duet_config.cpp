#include "enfilade/models/duet_config.h"

#include <fmt/format.h>

#include "enfilade/core/errors.h"
#include "enfilade/models/detail/named_values.h"

namespace enfilade::models {
namespace {

constexpr detail::NamedValues<Fusion, 2> kFusions{"fusion", {"dynamic", "average"}};

void require(bool possible, std::string_view name, std::int64_t value, std::string_view allowed) {
  if (possible) return;
  throw ArgumentError(fmt::format("DUET: {} is {}; allowed: {}", name, value, allowed));
}

}  // namespace

std::string_view to_string(Fusion value) noexcept { return kFusions.name(value); }
Fusion parse_fusion(std::string_view name) { return kFusions.parse(name); }

DuetConfig duet_preset(std::string_view name) {
  DuetConfig config;
  if (name == "duet") return config;
  if (name != "duet-s") {
    throw ArgumentError(fmt::format("{:?} is no size of DUET; there are duet, duet-s", name));
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
  const auto positive = [](std::string_view name, std::int64_t value, std::int64_t least = 1) {
    require(value >= least, name, value, fmt::format("{} or more", least));
  };
  positive("hidden", c.hidden);
  require(c.heads >= 1 && c.hidden % c.heads == 0, "heads", c.heads,
          fmt::format("a divisor of hidden, {}", c.hidden));
  positive("feed_forward", c.feed_forward);
  positive("panorama_feed_forward", c.panorama_feed_forward);
  positive("text_layers", c.text_layers, 0);
  positive("panorama_layers", c.panorama_layers, 0);
  positive("cross_layers", c.cross_layers, 0);
  positive("vocabulary", c.vocabulary);
  positive("positions", c.positions);
  positive("token_types", c.token_types, 2);
  positive("image", c.image, 0);
  positive("object", c.object, 0);
  require(c.max_words >= 1 && c.max_words <= c.positions, "max_words", c.max_words,
          fmt::format("1 to positions, {}", c.positions));
  require(c.max_actions >= 1 && c.max_actions <= c.steps, "max_actions", c.max_actions,
          fmt::format("1 to steps, {}", c.steps));
}

}  // namespace enfilade::models
