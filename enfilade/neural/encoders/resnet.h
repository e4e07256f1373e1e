/// \file  ResNets (He et al. 2016) as in torchvision.
#pragma once
#include <memory>

#include "enfilade/neural/encoder.h"

namespace enfilade::neural::encoders {

/// \pre config.name is resnet18, resnet50 or resnet152 \throws as make_encoder()
std::unique_ptr<ImageEncoder> make_resnet(const EncoderConfig& config);

}  // namespace enfilade::neural::encoders
