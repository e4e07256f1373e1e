#include "enfilade/neural/encoder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>

#include "enfilade/core/errors.h"
#include "enfilade/neural/encoders/make_encoders.h"

namespace enfilade::neural {

std::string_view to_string(Preprocessing preprocessing) noexcept {
  return preprocessing == Preprocessing::kCaffe ? "caffe" : "torchvision";
}

std::vector<std::string> encoder_names() {
  return {"resnet18",      "resnet50",      "resnet152", "vit-b-16",
          "clip-vit-b-16", "clip-vit-b-32", "home"};
}

std::unique_ptr<ImageEncoder> make_encoder(const EncoderConfig& config) {
  const std::vector<std::string> names = encoder_names();
  if (std::ranges::find(names, config.name) == names.end()) {
    throw LookupError(
        fmt::format("encoder {:?}: one of {} is expected", config.name, fmt::join(names, ", ")));
  }
  if (config.logits && config.name != "vit-b-16") {
    throw ArgumentError(fmt::format(
        "logits: encoder {:?} gives no class scores; vit-b-16 is expected", config.name));
  }
  if (config.name == "vit-b-16") return encoders::make_vit(config);
  if (config.name.starts_with("clip")) return encoders::make_clip(config);
  if (config.name == "home") return encoders::make_home_encoder(config);
  return encoders::make_resnet(config);
}

}  // namespace enfilade::neural
