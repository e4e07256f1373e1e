/// \file  The encoder `home`, from a file of `enfilade pretrain`.
#pragma once
#include <memory>

#include "enfilade/neural/encoder.h"

namespace enfilade::neural::encoders {

/// \pre config.name == "home" \throws as make_encoder()
std::unique_ptr<ImageEncoder> make_home_encoder(const EncoderConfig& config);

}  // namespace enfilade::neural::encoders
