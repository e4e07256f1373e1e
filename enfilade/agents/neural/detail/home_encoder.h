/// \file  What `enfilade pretrain` made, as an encoder.
#pragma once
#include <memory>

#include "enfilade/agents/neural/encoder.h"

namespace enfilade::agents::neural {

/// \pre config.name == "home" \throws as make_encoder()
std::unique_ptr<ImageEncoder> make_home_encoder(const EncoderConfig& config);

}  // namespace enfilade::agents::neural
