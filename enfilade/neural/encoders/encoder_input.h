/// \file  What encoders share, and those that make_encoder() chooses from.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "enfilade/geometry/camera.h"
#include "enfilade/neural/encoder.h"

namespace enfilade::neural::encoders {

/// Checks and holds the input of an encoder. A kind of encoder adds run().
class CheckedEncoder : public ImageEncoder {
 public:
  /// \param memory where pictures are read without a copy: a card, or the host
  explicit CheckedEncoder(c10::Device memory) : device_(memory) {}

  std::span<float> memory(std::size_t n, const Camera& camera) override;
  bool on_card() const override { return !device_.is_cpu(); }
  std::string weights_hash() const override { return hash_; }
  /// \throws ArgumentError for sizes that do not fit, or pictures smaller than 32 x 32
  void encode(std::span<const float> pictures, std::size_t n, const Camera& camera,
              std::span<float> features) override;

 protected:
  /// Features (n, dimensions()) of pictures. Without gradients.
  virtual at::Tensor run(std::span<const float> pictures, std::size_t n, const Camera& camera) = 0;
  /// The pictures as (n, 3, height, width), a view of the caller's memory or of memory().
  at::Tensor tensor(std::span<const float> pictures, std::size_t n, const Camera& camera) const;

  std::string hash_;  ///< of the weights

 private:
  c10::Device device_;
  at::Tensor memory_;
};

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
