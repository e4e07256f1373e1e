/// \file  Image encoders: networks that turn pictures into feature vectors.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/enum_names.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/render/renderer.h"

namespace enfilade::neural {

/// The normalisation of pictures before a ResNet.
enum class Preprocessing {
  kCaffe,        ///< 0..255, B G R, minus (103.1, 115.9, 123.2): the released R2R features
  kTorchvision,  ///< R G B in [0, 1], minus ImageNet's mean, by its deviation
};

/// Names in commands and files, in the order of the values.
constexpr std::array<std::string_view, 2> names_of(Preprocessing /*enum*/) {
  return {"caffe", "torchvision"};
}

/// Which network, with which weights, on which device.
struct EncoderConfig {
  std::string name = "resnet152";  ///< one of encoder_names()
  /// A file of safetensors or of torch.save(), with these names: ResNets torchvision's or timm's,
  /// "vit-b-16" timm's, CLIP OpenAI's or Hugging Face's. For "home", a file written by
  /// pretrain_home_encoder(). Empty: random weights by `seed` (for tests and timings).
  std::filesystem::path weights = {};
  /// The one that the weights were trained with. Caffe's ResNets are another network than
  /// torchvision's: their bottlenecks have the stride elsewhere, see docs/features.md.
  Preprocessing preprocessing = Preprocessing::kCaffe;  ///< others have their own
  std::string device = "cpu";                           ///< "cpu", "cuda", "cuda:1"
  std::uint64_t seed = 1;                               ///< of random weights
  /// Whether the 1,000 scores of ImageNet's classes, ahead of the softmax, follow the features:
  /// what HAMT and DUET are pretrained with. "vit-b-16" only.
  bool logits = false;
};
/// resnet18, resnet50, resnet152, vit-b-16, clip-vit-b-16, clip-vit-b-32, home
std::vector<std::string> encoder_names();

/// Pictures to features: the mean-pooled last layer of a ResNet, a Vision Transformer's token for
/// the picture as a whole. One thread at a time; it computes on libtorch's threads.
class ImageEncoder {
 public:
  virtual ~ImageEncoder() = default;
  /// 2048; 512 for resnet18 and CLIP; 768 for vit-b-16, 1768 with its class scores
  virtual std::size_t dimensions() const = 0;
  /// The normalisation that the renderer has to apply to its float pictures
  /// (ColourFormat::kPlanarFloat32).
  virtual render::Normalisation normalisation() const = 0;
  virtual Camera camera() const = 0;  ///< of its training pictures: 640 x 480, 60 degrees.
  /// Memory of (n, 3, height, width) in which encode() reads pictures without a copy, until the
  /// next call. On the encoder's card if on_card(), then to be filled in the order of the legacy
  /// default stream; else of the host.
  virtual std::span<float> memory(std::size_t n, const Camera& camera) = 0;
  /// Whether memory() is on a card.
  virtual bool on_card() const = 0;
  /// Computes features of n pictures.
  /// \param pictures (n, 3, height, width), R G B, as the renderer fills them with normalisation();
  /// of the host, or memory()
  /// \param features (n, dimensions()) \throws ArgumentError for sizes that do not fit
  virtual void encode(std::span<const float> pictures, std::size_t n, const Camera& camera,
                      std::span<float> features) = 0;
  virtual std::string weights_hash() const = 0;  ///< 16 hex digits over names and values
  /// Its name in feature files: "caffe", "torchvision", "vit", "clip", "home".
  virtual std::string preprocessing() const = 0;
};

/// Loads an encoder.
/// \throws LookupError for an unknown name
/// \throws FileError, InvalidInput for the weights, naming every missing, surplus and wrong-shaped
/// array at once
/// \throws ArgumentError for class scores of an encoder without them
/// \throws Error for a device that is not available
std::unique_ptr<ImageEncoder> make_encoder(const EncoderConfig& config);

}  // namespace enfilade::neural
