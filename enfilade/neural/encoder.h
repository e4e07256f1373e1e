/// \file  Image encoders: networks that turn pictures into feature vectors.
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

/// The normalisation of pictures before the network.
enum class Preprocessing {
  kCaffe,        ///< 0..255, B G R, minus (103.1, 115.9, 123.2): the released R2R features
  kTorchvision,  ///< R G B in [0, 1], minus ImageNet's mean, by its deviation
};

std::string_view to_string(Preprocessing preprocessing) noexcept;  ///< "caffe", "torchvision"

/// Which network, with which weights, on which device.
struct EncoderConfig {
  std::string name = "resnet152";  ///< one of encoder_names()
  /// safetensors (torchvision's or timm's names) or torchvision's .pth; for "home", a file written
  /// by pretrain_home_encoder(). Empty: random weights by `seed` (for tests and timings).
  std::filesystem::path weights = {};
  /// The one that the weights were trained with. Caffe's ResNets are another network than
  /// torchvision's: their bottlenecks have the stride elsewhere, see docs/features.md.
  Preprocessing preprocessing = Preprocessing::kCaffe;  ///< "home" has its own
  std::string device = "cpu";                           ///< "cpu", "cuda", "cuda:1"
  std::uint64_t seed = 1;                               ///< of random weights
};
std::vector<std::string> encoder_names();  ///< resnet18, resnet50, resnet152, home

/// The mean-pooled last layer of a convolutional network. One thread at a time; it computes on
/// libtorch's threads.
class ImageEncoder {
 public:
  virtual ~ImageEncoder() = default;
  virtual std::size_t dimensions() const = 0;  ///< 2048; 512 for resnet18
  /// The normalisation that the renderer has to apply to its float pictures
  /// (ColourFormat::kPlanarFloat32).
  virtual render::Normalisation normalisation() const = 0;
  virtual Camera camera() const = 0;  ///< of the pictures it was trained on: 640 x 480, 60 degrees
  /// Computes features of n pictures.
  /// \param pictures (n, 3, height, width), R G B, as the renderer fills them with normalisation()
  /// \param features (n, dimensions()) \throws ArgumentError for sizes that do not fit
  virtual void encode(std::span<const float> pictures, std::size_t n, const Camera& camera,
                      std::span<float> features) = 0;
  virtual std::string weights_hash() const = 0;  ///< 16 hex digits over names and values
};

/// Loads an encoder. \throws LookupError for an unknown name; FileError, InvalidInput for the
/// weights, naming every missing, surplus and wrong-shaped array at once; Error for a device that
/// is not available
std::unique_ptr<ImageEncoder> make_encoder(const EncoderConfig& config);

}  // namespace enfilade::neural
