/// \file  The encoders that make_encoder() chooses from.
#pragma once
#include <memory>

#include "enfilade/neural/encoder.h"

namespace enfilade::neural::encoders {

/// From a file of `enfilade pretrain`. \pre config.name == "home" \throws as make_encoder()
std::unique_ptr<ImageEncoder> make_home_encoder(const EncoderConfig& config);

/// ResNets (He et al. 2016) as in torchvision. \pre config.name is resnet18, resnet50 or resnet152
/// \throws as make_encoder()
std::unique_ptr<ImageEncoder> make_resnet(const EncoderConfig& config);

/// ViT-B/16 as in timm. \pre config.name == "vit-b-16" \throws as make_encoder()
std::unique_ptr<ImageEncoder> make_vit(const EncoderConfig& config);

/// CLIP's encoders of pictures. \pre config.name is clip-vit-b-16 or clip-vit-b-32 \throws as
/// make_encoder()
std::unique_ptr<ImageEncoder> make_clip(const EncoderConfig& config);

}  // namespace enfilade::neural::encoders
