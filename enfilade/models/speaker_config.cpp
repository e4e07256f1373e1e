#include "enfilade/models/speaker_config.h"

#include "enfilade/models/detail/lstm_sizes.h"

namespace enfilade::models {

void validate(const SpeakerConfig& config) {
  detail::validate_sizes(config, {{"vocabulary", config.vocabulary},
                                  {"word_embedding", config.word_embedding},
                                  {"hidden", config.hidden},
                                  {"angle", config.angle}});
}

}  // namespace enfilade::models
