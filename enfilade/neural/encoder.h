/// \file  Networks that turn pictures into feature vectors.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/geometry/camera.h"
#include "enfilade/render/renderer.h"

namespace enfilade::neural {

/// What a picture's numbers are before the network sees them.
enum class Preprocessing {
  kCaffe,        ///< 0..255, B G R, minus (103.1, 115.9, 123.2): the released R2R features
  kTorchvision,  ///< R G B in [0, 1], minus ImageNet's mean, by its deviation
};

std::string_view to_string(Preprocessing preprocessing) noexcept;  ///< "caffe", "torchvision"

/// Which image encoder, and with which weights.
struct EncoderConfig {
  std::string name = "resnet152";  ///< one of encoder_names()
  /// safetensors (torchvision's or timm's names) or torchvision's .pth; of "home", a file that
  /// pretrain_home_encoder() wrote. Empty: random weights by `seed` (for tests and timings).
  std::filesystem::path weights = {};
  /// What the weights were trained with. Torchvision's are a network of their own, not Caffe's,
  /// whose bottlenecks have their stride elsewhere: see docs/features.md.
  Preprocessing preprocessing = Preprocessing::kCaffe;  ///< "home" has its own
  std::string device = "cpu";                           ///< "cpu", "cuda", "cuda:1"
  std::uint64_t seed = 1;                               ///< of random weights
};
std::vector<std::string> encoder_names();  ///< resnet18, resnet50, resnet152, home

/// The mean-pooled last layer of a convolutional network. One thread at a time; computes on
/// libtorch's.
class ImageEncoder {
 public:
  virtual ~ImageEncoder() = default;
  virtual std::size_t dimensions() const = 0;  ///< 2048; 512 for resnet18
  /// How the renderer is to make its float pictures (ColourFormat::kPlanarFloat32), so that
  /// encode() needs no pass over pixels of its own.
  virtual render::Normalisation normalisation() const = 0;
  virtual Camera camera() const = 0;  ///< that it was made for; 640 x 480, 60 degrees
  /// \param pictures (n, 3, height, width), R G B, as the renderer fills them with normalisation()
  /// \param features (n, dimensions()) \throws ArgumentError for sizes that do not fit
  virtual void encode(std::span<const float> pictures, std::size_t n, const Camera& camera,
                      std::span<float> features) = 0;
  virtual std::string weights_hash() const = 0;  ///< 16 hex digits over names and values
};

/// \throws LookupError for an unknown name; FileError, InvalidInput for the weights, naming every
/// missing, surplus and wrong-shaped array at once; Error for a device that is not there
std::unique_ptr<ImageEncoder> make_encoder(const EncoderConfig& config);

}  // namespace enfilade::neural
