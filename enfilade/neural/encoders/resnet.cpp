#include <ATen/ATen.h>
#include <c10/core/InferenceMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <optional>

#include "enfilade/core/check.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/encoders/convolution.h"
#include "enfilade/neural/encoders/encoder_input.h"

namespace enfilade::neural::encoders {
namespace {

struct Architecture {
  std::string_view name;
  std::array<int, 4> blocks;  ///< a stage
  bool bottleneck;            ///< 1x1, 3x3, 1x1 instead of two 3x3
};
constexpr std::array<Architecture, 3> kArchitectures{{{"resnet18", {2, 2, 2, 2}, false},
                                                      {"resnet50", {3, 4, 6, 3}, true},
                                                      {"resnet152", {3, 8, 36, 3}, true}}};
constexpr std::int64_t kStemChannels = 64, kBottleneckExpansion = 4;

const Architecture& architecture(std::string_view name) {
  const auto found = std::ranges::find(kArchitectures, name, &Architecture::name);
  EN_CHECK(found != kArchitectures.end());
  return *found;
}

// A convolution and the normalisation behind it, by their names in weight files.
struct Layer {
  std::string convolution, norm;
  std::int64_t in, out, size, stride;
  Convolution loaded = {};  // with the normalisation folded in
};

struct Block {
  std::vector<Layer> layers;
  std::optional<Layer> shortcut;
};

// Of version 1.5, which torchvision has: a bottleneck's stride is in its 3 x 3 convolution.
// (Caffe's ResNet-152, and so the released R2R features, have it in the first 1 x 1.)
Block plan_block(const std::string& name, bool bottleneck, std::int64_t in, std::int64_t width,
                 std::int64_t stride) {
  const std::int64_t out = bottleneck ? width * kBottleneckExpansion : width;
  Block plan;
  const auto add = [&](std::int64_t from, std::int64_t to, std::int64_t size, std::int64_t step) {
    const std::size_t number = plan.layers.size() + 1;
    plan.layers.push_back({fmt::format("{}.conv{}", name, number),
                           fmt::format("{}.bn{}", name, number), from, to, size, step});
  };
  if (bottleneck) {
    add(in, width, 1, 1);
    add(width, width, 3, stride);
    add(width, out, 1, 1);
  } else {
    add(in, width, 3, stride);
    add(width, width, 3, 1);
  }
  if (stride != 1 || in != out) {
    plan.shortcut = Layer{name + ".downsample.0", name + ".downsample.1", in, out, 1, stride};
  }
  return plan;
}

struct Plan {
  Layer stem{"conv1", "bn1", 3, kStemChannels, 7, 2};
  std::vector<Block> blocks;
  std::int64_t features = 0;

  std::vector<Layer*> layers() {
    std::vector<Layer*> all{&stem};
    for (Block& block : blocks) {
      for (Layer& layer : block.layers) all.push_back(&layer);
      if (block.shortcut) all.push_back(&*block.shortcut);
    }
    return all;
  }
};

Plan plan_network(const Architecture& a) {
  Plan plan;
  std::int64_t in = kStemChannels, width = kStemChannels;
  for (std::size_t stage = 0; stage < a.blocks.size(); ++stage, width *= 2) {
    for (int b = 0; b < a.blocks.at(stage); ++b) {
      const std::int64_t stride = b == 0 && stage > 0 ? 2 : 1;
      plan.blocks.push_back(
          plan_block(fmt::format("layer{}.{}", stage + 1, b), a.bottleneck, in, width, stride));
      in = a.bottleneck ? width * kBottleneckExpansion : width;
    }
  }
  plan.features = in;
  return plan;
}

constexpr std::array<const char*, 4> kNormArrays{".weight", ".bias", ".running_mean",
                                                 ".running_var"};

std::vector<core::ArraySpec> arrays_of(Plan& plan) {
  std::vector<core::ArraySpec> arrays;
  for (const Layer* l : plan.layers()) {
    arrays.push_back({l->convolution + ".weight", {l->out, l->in, l->size, l->size}});
    for (const char* array : kNormArrays) arrays.push_back({l->norm + array, {l->out}});
  }
  return arrays;
}

// The classifier, and a counter of training steps: not used in inference.
bool is_unused(std::string_view name) {
  return name.starts_with("fc.") || name.ends_with(".num_batches_tracked");
}

// Normalisations are the identity, except the last of each block, which halves: otherwise values
// would double from block to block.
core::Weights random_weights(Plan& plan, std::uint64_t seed) {
  core::Weights weights;
  Rng rng(seed);
  for (const core::ArraySpec& array : arrays_of(plan)) {
    const bool zeros = array.name.ends_with(".running_mean") || array.name.ends_with(".bias");
    weights[array.name] = array.shape.size() > 1 ? core::he_normal(array.shape, rng)
                          : zeros                ? at::zeros(array.shape)
                                                 : at::ones(array.shape);
  }
  constexpr double kHalf = 0.5;
  for (const Block& block : plan.blocks) {
    weights.at(block.layers.back().norm + ".weight").mul_(kHalf);
  }
  return weights;
}

class ResNet final : public CheckedEncoder {
 public:
  explicit ResNet(const EncoderConfig& config) : ResNet(config, core::open_device(config.device)) {}
  ResNet(const EncoderConfig& config, c10::Device device)
      : CheckedEncoder(device),
        preprocessing_(config.preprocessing),
        device_(device),
        plan_(plan_network(architecture(config.name))) {
    const core::Weights weights =
        config.weights.empty() ? random_weights(plan_, config.seed)
                               : core::read_weights(features::TensorFile::open(config.weights),
                                                    arrays_of(plan_), is_unused);
    hash_ = core::hash_of(weights);
    const c10::InferenceMode no_gradients;
    for (Layer* layer : plan_.layers()) layer->loaded = make(*layer, weights);
  }

  std::size_t dimensions() const override { return static_cast<std::size_t>(plan_.features); }
  Camera camera() const override { return {640, 480, degrees(60)}; }
  std::string preprocessing() const override { return std::string(enum_name(preprocessing_)); }

  render::Normalisation normalisation() const override {
    if (preprocessing_ == Preprocessing::kTorchvision) return render::kImageNet;
    constexpr float kFull = 255;
    return {{123.2F / kFull, 115.9F / kFull, 103.1F / kFull}, {1 / kFull, 1 / kFull, 1 / kFull}};
  }

 private:
  at::Tensor run(std::span<const float> pictures, std::size_t n, const Camera& camera) override {
    return forward(prepare(tensor(pictures, n, camera), device_, layout_));
  }

  Convolution make(const Layer& layer, const core::Weights& weights) const {
    const auto norm = [&](const char* array) { return weights.at(layer.norm + array); };
    Convolution c;
    c.weight = weights.at(layer.convolution + ".weight");
    c.stride = layer.stride;
    c.padding = layer.size / 2;
    // The renderer's pictures are R G B; a network made for Caffe's pictures wants B G R.
    if (layer.in == 3 && preprocessing_ == Preprocessing::kCaffe) c.weight = c.weight.flip(1);
    fold({norm(".weight"), norm(".bias"), norm(".running_mean"), norm(".running_var")}, c);
    prepare(c, device_, layout_);
    return c;
  }

  static at::Tensor run(const Block& block, const at::Tensor& x) {
    at::Tensor y = x;
    for (std::size_t i = 0; i < block.layers.size(); ++i) {
      y = apply(block.layers[i].loaded, y);
      if (i + 1 < block.layers.size()) y = at::relu_(y);
    }
    y.add_(block.shortcut ? apply(block.shortcut->loaded, x) : x);
    return at::relu_(y);
  }

  at::Tensor forward(at::Tensor x) const {
    x = apply(plan_.stem.loaded, x);
    x = at::max_pool2d(at::relu_(x), {3, 3}, {2, 2}, {1, 1});
    for (const Block& block : plan_.blocks) x = run(block, x);
    if (layout_ == ActivationLayout::kOneDnn) x = x.to_dense();
    return x.mean({2, 3});
  }

  Preprocessing preprocessing_;
  c10::Device device_;
  ActivationLayout layout_ = best_layout(device_);
  Plan plan_;
};

}  // namespace

std::unique_ptr<ImageEncoder> make_resnet(const EncoderConfig& config) {
  return std::make_unique<ResNet>(config);
}

}  // namespace enfilade::neural::encoders
