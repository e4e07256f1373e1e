#include "enfilade/neural/compute_features.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/render/renderer.h"

namespace enfilade::neural {
namespace {

using Clock = std::chrono::steady_clock;

using Place = graph::Location;

struct Places {
  std::vector<Place> all;
  std::vector<std::string> without;
};

// A set may name scans whose pictures are not on this machine.
void add_places(const scan::PanoramaSet& panoramas, ScanIndex scan, Places& places) {
  const scan::PanoramaSource* source = nullptr;
  try {
    source = &panoramas.source(scan);
  } catch (const LookupError&) {
    places.without.push_back(panoramas.scans()[scan.at()]);
    return;
  }
  const std::size_t before = places.all.size();
  for (std::size_t v = 0; v < source->size(); ++v) {
    if (!source->poses()[v].included) continue;
    if (source->face_sizes(ViewpointIndex(v))[index(scan::Layer::kColour)] == 0) continue;
    places.all.push_back({scan, ViewpointIndex(v)});
  }
  if (places.all.size() == before) places.without.push_back(source->scan());
}

void check(const FeatureJob& job) {
  if (job.batch == 0) throw ArgumentError("batch: 0; at least 1 is expected");
  if (job.shard.index >= job.shard.count) {
    throw ArgumentError(fmt::format("shard: {} of {}; from 0 to one less than the number of shards",
                                    job.shard.index, job.shard.count));
  }
}

Places places_of(const scan::PanoramaSet& panoramas, Shard shard) {
  Places places;
  for (std::size_t s = 0; s < panoramas.size(); ++s) {
    add_places(panoramas, ScanIndex(s), places);
  }
  std::vector<Place> ours;
  for (std::size_t i = shard.index; i < places.all.size(); i += shard.count) {
    ours.push_back(places.all[i]);
  }
  if (ours.empty()) {
    throw ArgumentError(fmt::format("nothing to do: {} viewpoints of {} scans have pictures",
                                    places.all.size(), panoramas.size()));
  }
  places.all = std::move(ours);
  return places;
}

// Renders and encodes one viewpoint after the other, in memory that is allocated once.
class Computation {
 public:
  Computation(const std::shared_ptr<const scan::PanoramaSet>& panoramas, const FeatureJob& job)
      : encoder_(make_encoder(job.encoder)),
        camera_(encoder_->camera()),
        batch_(std::min(job.batch, render::kDiscreteViews)),
        picture_(std::size_t{3} * camera_.width * camera_.height),
        pictures_(encoder_->memory(batch_, camera_)),
        features_(render::kDiscreteViews * encoder_->dimensions()) {
    faces_ = std::make_shared<render::FaceCache>(panoramas,
                                                 render::FaceCacheConfig{.threads = job.threads});
    render::RendererConfig config;
    config.threads = job.threads;
    if (encoder_->on_card()) {
      // Drawn where they are read: pictures never leave the card.
      config.backend = render::Backend::kCuda;
      const std::string& device = job.encoder.device;
      config.cuda_device = device.substr(std::min(device.find(':'), device.size() - 1) + 1);
    }
    renderer_ = render::make_renderer(faces_, config);
  }

  features::FeatureInfo info(const FeatureJob& job) const {
    return {.encoder = job.encoder.name,
            .preprocessing = encoder_->preprocessing(),
            .weights = encoder_->weights_hash(),
            .views = render::kDiscreteViews,
            .dimensions = encoder_->dimensions(),
            .camera = camera_,
            .type = job.type};
  }

  // Decoded while the encoder works.
  void prefetch(Place place) {
    std::array<render::FaceKey, kCubeFaces> keys;
    for (std::size_t f = 0; f < kCubeFaces; ++f) {
      keys.at(f) = {place.scan, place.viewpoint, scan::Layer::kColour, cube_face(f)};
    }
    faces_->prefetch(keys);
  }

  // (36, dimensions), valid until the next call.
  std::span<const float> compute(Place place, FeatureReport& report) {
    const auto views = render::discrete_views(place.scan, place.viewpoint);
    for (std::size_t first = 0; first < views.size(); first += batch_) {
      const std::size_t n = std::min(batch_, views.size() - first);
      const std::span<float> pictures = pictures_.first(n * picture_);
      const Clock::time_point start = Clock::now();
      render::Outputs outputs;
      outputs.colour = {render::ColourFormat::kPlanarFloat32, encoder_->normalisation(),
                        std::as_writable_bytes(pictures)};
      // The encoder's own stream, so there is no wait in between.
      if (encoder_->on_card()) outputs.stream = render::CudaStream{};
      renderer_->render(camera_, std::span(views).subspan(first, n), outputs);
      const Clock::time_point drawn = Clock::now();
      const std::size_t size = encoder_->dimensions();
      encoder_->encode(pictures, n, camera_, std::span(features_).subspan(first * size, n * size));
      report.rendering_seconds += std::chrono::duration<double>(drawn - start).count();
      report.encoding_seconds += std::chrono::duration<double>(Clock::now() - drawn).count();
    }
    return features_;
  }

 private:
  std::unique_ptr<ImageEncoder> encoder_;
  Camera camera_;
  std::size_t batch_, picture_;
  std::span<float> pictures_;  // the encoder's
  std::vector<float> features_;
  std::shared_ptr<render::FaceCache> faces_;
  std::unique_ptr<render::Renderer> renderer_;
};

std::vector<features::FeatureKey> keys_of(const scan::PanoramaSet& panoramas,
                                          const std::vector<Place>& places) {
  std::vector<features::FeatureKey> keys;
  for (const Place& place : places) {
    const scan::PanoramaSource& source = panoramas.source(place.scan);
    keys.push_back({source.scan(), source.poses()[place.viewpoint.at()].viewpoint});
  }
  return keys;
}

}  // namespace

FeatureReport compute_features(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                               const FeatureJob& job, const std::filesystem::path& file,
                               const Progress& progress) {
  check(job);
  Places places = places_of(*panoramas, job.shard);
  FeatureReport report{.viewpoints = places.all.size(), .without = std::move(places.without)};
  Computation computation(panoramas, job);
  auto writer =
      features::FeatureWriter::create(file, computation.info(job), keys_of(*panoramas, places.all));
  report.resumed = places.all.size() - writer.rows_left();
  for (std::size_t row = 0; row < places.all.size(); ++row) {
    if (progress) progress(row, places.all.size());
    if (writer.written(row)) continue;
    if (row + 1 < places.all.size()) computation.prefetch(places.all[row + 1]);
    writer.write(row, computation.compute(places.all[row], report));
  }
  writer.finish();
  if (progress) progress(places.all.size(), places.all.size());
  return report;
}

}  // namespace enfilade::neural
