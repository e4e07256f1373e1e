#include <ATen/ATen.h>
#include <c10/core/InferenceMode.h>
#include <fmt/format.h>
#include <algorithm>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/random_weights.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/encoders/encoder_input.h"
#include "enfilade/neural/encoders/home_network.h"
#include "enfilade/neural/encoders/make_encoders.h"

namespace enfilade::neural::encoders {
namespace {

// An untrained network with about as many classes and rooms as model homes have.
HomeFile random_network(std::uint64_t seed) {
  HomeFile home;
  home.words.rooms = "abcdefghij";
  for (std::int64_t i = 0; i < 36; ++i) home.words.classes.push_back(i);
  Rng rng(seed);
  for (const core::ArraySpec& array : home_arrays(home.words)) {
    home.weights[array.name] = array.shape.size() > 1 ? core::he_normal(array.shape, rng)
                               : array.name == "features.deviation" ? at::ones(array.shape)
                                                                    : at::zeros(array.shape);
  }
  return home;
}

class HomeEncoder final : public ImageEncoder {
 public:
  HomeEncoder(const HomeFile& file, c10::Device device)
      : network_(file.weights, device),
        mean_(file.weights.at("features.mean").to(device)),
        deviation_(file.weights.at("features.deviation").to(device)),
        hash_(core::hash_of(file.weights)),
        input_(device) {}

  std::size_t dimensions() const override { return static_cast<std::size_t>(mean_.numel()); }
  Camera camera() const override { return {kHomeWidth, kHomeHeight, degrees(60)}; }
  std::span<float> memory(std::size_t n, const Camera& camera) override {
    return input_.take(n, camera);
  }
  bool on_card() const override { return input_.on_card(); }
  std::string weights_hash() const override { return hash_; }
  std::string preprocessing() const override { return "home"; }
  render::Normalisation normalisation() const override {
    return {{kHomeMean, kHomeMean, kHomeMean}, {kHomeDeviation, kHomeDeviation, kHomeDeviation}};
  }

  void encode(std::span<const float> pictures, std::size_t n, const Camera& camera,
              std::span<float> features) override {
    if (camera.width != kHomeWidth || camera.height != kHomeHeight) {
      throw ArgumentError(fmt::format("camera: {} x {} pixels; this encoder looks at {} x {}",
                                      camera.width, camera.height, kHomeWidth, kHomeHeight));
    }
    check_sizes(pictures.size(), n, camera, dimensions(), features.size());
    if (n == 0) return;
    const c10::InferenceMode no_gradients;
    const at::Tensor seen = describe(network_.run(input_.tensor(pictures, n, camera)));
    const at::Tensor output = ((seen - mean_) / deviation_).cpu().contiguous();
    std::ranges::copy_n(output.data_ptr<float>(), output.numel(), features.begin());
  }

 private:
  HomeNetwork network_;
  at::Tensor mean_, deviation_;
  std::string hash_;
  PictureMemory input_;
};

}  // namespace

std::unique_ptr<ImageEncoder> make_home_encoder(const EncoderConfig& config) {
  const c10::Device device = core::open_device(config.device);
  return std::make_unique<HomeEncoder>(
      config.weights.empty() ? random_network(config.seed) : read_home_network(config.weights),
      device);
}

}  // namespace enfilade::neural::encoders
