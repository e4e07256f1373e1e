#include "enfilade/service/browsing/faces.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/draw/colour_maps.h"
#include "enfilade/image/codecs.h"
#include "enfilade/service/browsing/layers.h"

namespace enfilade::service::browsing {
namespace {

constexpr int kJpegQuality = 92;

std::shared_ptr<const std::string> file_of(const std::vector<std::uint8_t>& bytes) {
  return std::make_shared<const std::string>(reinterpret_cast<const char*>(bytes.data()),
                                             bytes.size());
}

FaceFiles make_files(const scan::PanoramaSource& source, ViewpointIndex viewpoint,
                     scan::Layer layer) {
  if (source.face_sizes(viewpoint)[index(layer)] == 0) {
    throw LookupError(fmt::format("this viewpoint has no {} pictures", to_string(layer)));
  }
  FaceFiles files;
  const bool colour = layer == scan::Layer::kColour;
  if (auto jpegs = colour ? source.colour_jpegs(viewpoint) : std::nullopt) {
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      files[k] = std::make_shared<const std::string>(std::move((*jpegs)[k]));
    }
    return files;
  }
  const scan::Panorama panorama = scan::read_panorama(source, viewpoint, scan::mask_of(layer));
  const double farthest = farthest_of(panorama.depth);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    files[k] =
        file_of(colour ? image::encode_jpeg(panorama.colour[k], kJpegQuality)
                       : image::encode_png(layer == scan::Layer::kDepth
                                               ? draw::colour_depth(panorama.depth[k], farthest)
                                               : draw::colour_ids(panorama.classes[k])));
  }
  return files;
}

std::size_t bytes_of(const FaceFiles& files) {
  std::size_t bytes = 0;
  for (const auto& file : files) bytes += file == nullptr ? 0 : file->size();
  return bytes;
}

}  // namespace

Faces::Faces(const scan::PanoramaSet& panoramas, std::size_t most_bytes)
    : panoramas_(panoramas), kept_(most_bytes, bytes_of) {}

FaceFiles Faces::get(ScanIndex scan, ViewpointIndex viewpoint, scan::Layer layer) {
  return find_or_make({scan, viewpoint,
                       layer == scan::Layer::kColour  ? Kind::kColour
                       : layer == scan::Layer::kDepth ? Kind::kDepth
                                                      : Kind::kClass});
}

std::shared_ptr<const std::string> Faces::distances(ScanIndex scan, ViewpointIndex viewpoint) {
  return find_or_make({scan, viewpoint, Kind::kDistances})[0];
}

std::shared_ptr<const std::string> Faces::legends(ScanIndex scan, ViewpointIndex viewpoint) {
  return find_or_make({scan, viewpoint, Kind::kLegends})[0];
}

FaceFiles Faces::make(const Key& key) const {
  const auto& [scan, viewpoint, kind] = key;
  const scan::PanoramaSource& source = panoramas_.source(scan);
  FaceFiles files;
  switch (kind) {
    case Kind::kColour:
      files = make_files(source, viewpoint, scan::Layer::kColour);
      break;
    case Kind::kDepth:
      files = make_files(source, viewpoint, scan::Layer::kDepth);
      break;
    case Kind::kClass:
      files = make_files(source, viewpoint, scan::Layer::kClass);
      break;
    case Kind::kDistances:
      files[0] = std::make_shared<const std::string>(distance_grid(source, viewpoint));
      break;
    case Kind::kLegends:
      files[0] = std::make_shared<const std::string>(legends_json(source, viewpoint).dump());
      break;
  }
  source.release(viewpoint);  // what was made are copies; visitors walk through whole buildings
  return files;
}

FaceFiles Faces::find_or_make(const Key& key) {
  return kept_.get(key, [&] { return make(key); });
}

std::string Faces::version(ScanIndex scan) {
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = versions_.find(scan); found != versions_.end()) return found->second;
  }
  const std::string state = panoramas_.source(scan).state();
  const std::string version =
      state.empty() ? "" : fmt::format("{:016x}", stream_of(state.data(), state.size()));
  const std::scoped_lock lock(mutex_);
  return versions_.emplace(scan, version).first->second;
}

}  // namespace enfilade::service::browsing
