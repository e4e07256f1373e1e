#include "enfilade/neural/continuous/sight.h"

#include <algorithm>
#include <map>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/half.h"
#include "enfilade/neural/continuous/network.h"

namespace enfilade::neural::continuous {
namespace {

constexpr std::size_t kMostKnown = 4;  // buildings that are not looked at now; some 50 MB each
constexpr std::uint32_t kDepthPixels = 64;
constexpr std::size_t kCell = kDepthPixels / static_cast<std::size_t>(kDepthCells);
constexpr float kFarthest = 10;  // metres, as VLN-CE's depth

Camera camera_of(const ImageEncoder& encoder, const std::string& name) {
  return name.starts_with("resnet") ? Camera{224, 224, degrees(90)} : encoder.camera();
}

// The mean of each cell. \param pixels (kDepthPixels, kDepthPixels) metres, 0: no surface
void average(std::span<const float> pixels, std::span<std::uint8_t> cells) {
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    const std::size_t row = cell / kDepthCells * kCell, column = cell % kDepthCells * kCell;
    float sum = 0;
    for (std::size_t y = row; y < row + kCell; ++y) {
      for (std::size_t x = column; x < column + kCell; ++x) {
        const float metres = pixels[y * kDepthPixels + x];
        sum += metres == 0 ? kFarthest : std::min(metres, kFarthest);
      }
    }
    const float share = sum / (kFarthest * static_cast<float>(kCell * kCell));
    cells[cell] = static_cast<std::uint8_t>(share * 255 + 0.5F);
  }
}

}  // namespace

Sight::Sight(const ContinuousSight& config) : config_(config) {
  if (!config_.scene_of) throw ArgumentError("scene_of: empty, but the agent is to see");
  encoder_ = make_encoder(config_.encoder);
  camera_ = camera_of(*encoder_, config_.encoder.name);
}

features::FeatureInfo Sight::info() const {
  return {.encoder = config_.encoder.name,
          .preprocessing = encoder_->preprocessing(),
          .weights = encoder_->weights_hash(),
          .views = 1,
          .dimensions = encoder_->dimensions(),
          .camera = camera_,
          .type = features::DType::kFloat16};
}

enfilade::continuous::Eyes& Sight::eyes_of(const std::string& scan) {
  const auto found = std::ranges::find(known_, scan, &Known::scan);
  if (found != known_.end()) {
    known_.splice(known_.begin(), known_, found);
  } else {
    known_.push_front({scan, std::make_unique<enfilade::continuous::Eyes>(
                                 std::vector{config_.scene_of(scan)},
                                 enfilade::continuous::EyesConfig{.threads = config_.threads})});
  }
  return *known_.front().eyes;
}

void Sight::draw(const std::string& scan, std::span<const enfilade::continuous::MeshView> views,
                 std::span<float> pictures, std::span<float> depth) {
  enfilade::continuous::Eyes& eyes = eyes_of(scan);
  render::Outputs colour;
  colour.colour = render::ColourOutput{render::ColourFormat::kPlanarFloat32,
                                       encoder_->normalisation(), std::as_writable_bytes(pictures)};
  eyes.render(camera_, views, colour);
  render::Outputs metres;
  metres.depth = render::DepthOutput{.pixels = std::as_writable_bytes(depth)};
  eyes.render(Camera{kDepthPixels, kDepthPixels, degrees(90)}, views, metres);
}

Seen Sight::look(std::span<const agents::ContinuousObservation> batch,
                 std::span<const std::size_t> rows, double eye_height) {
  std::map<std::string, std::vector<std::size_t>> by_scan;  // places among `rows`
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const agents::ContinuousObservation& seen = batch[rows[r]];
    by_scan[seen.buildings->scan(seen.building)].push_back(r);
  }
  // Those of this step stay, however many: the next step needs them again.
  while (known_.size() > kMostKnown && !by_scan.contains(known_.back().scan)) known_.pop_back();
  const std::size_t pixels = std::size_t{camera_.width} * camera_.height * 3;
  constexpr std::size_t kDepth = std::size_t{kDepthPixels} * kDepthPixels;
  const std::span<float> pictures = encoder_->memory(rows.size(), camera_);
  std::vector<float> depth(rows.size() * kDepth);
  std::vector<std::size_t> order;
  for (const auto& [scan, places] : by_scan) {
    std::vector<enfilade::continuous::MeshView> views;
    for (const std::size_t r : places) {
      const enfilade::continuous::Pose& pose = batch[rows[r]].pose;
      const Vec3d feet = to_double(pose.position);
      views.push_back({0, {feet.x, feet.y, feet.z + eye_height}, pose.heading, pose.elevation});
    }
    draw(scan, views, pictures.subspan(order.size() * pixels, views.size() * pixels),
         std::span(depth).subspan(order.size() * kDepth, views.size() * kDepth));
    order.insert(order.end(), places.begin(), places.end());
  }
  const std::size_t width = encoder_->dimensions();
  std::vector<float> features(rows.size() * width);
  encoder_->encode(pictures, rows.size(), camera_, features);
  Seen seen{std::vector<std::uint16_t>(features.size()),
            std::vector<std::uint8_t>(rows.size() * kDepthSize)};
  for (std::size_t k = 0; k < order.size(); ++k) {
    std::ranges::transform(std::span(features).subspan(k * width, width),
                           seen.pictures.begin() + static_cast<std::ptrdiff_t>(order[k] * width),
                           to_half);
    average(std::span(depth).subspan(k * kDepth, kDepth),
            std::span(seen.depth).subspan(order[k] * kDepthSize, kDepthSize));
  }
  return seen;
}

}  // namespace enfilade::neural::continuous
