#include "enfilade/models/panoramic_config.h"

#include "enfilade/models/detail/lstm_sizes.h"
#include "enfilade/models/detail/named_values.h"

namespace enfilade::models {

namespace {

constexpr detail::NamedValues<Subout, 3> kSubouts{"subout", {"tanh", "max", "own-max"}};

}  // namespace

std::string_view to_string(Subout value) noexcept { return kSubouts.name(value); }
Subout parse_subout(std::string_view name) { return kSubouts.parse(name); }

void validate(const PanoramicConfig& config) {
  detail::validate_sizes(config, {{"vocabulary", config.vocabulary},
                                  {"word_embedding", config.word_embedding},
                                  {"action_embedding", config.action_embedding},
                                  {"hidden", config.hidden},
                                  {"angle", config.angle}});
}

}  // namespace enfilade::models
