#include "enfilade/service/browsing/faces.h"

#include <fmt/format.h>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/draw/colour_maps.h"
#include "enfilade/image/codecs.h"

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
  const auto mask = static_cast<scan::LayerMask>(1U << index(layer));
  const scan::Panorama panorama = scan::read_panorama(source, viewpoint, mask);
  double farthest = 0;  // one scale for all six depth maps, or the edges of faces would show
  for (const auto& face : panorama.depth) {
    farthest = std::max(farthest, draw::farthest_depth(face));
  }
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    files[k] =
        file_of(colour ? image::encode_jpeg(panorama.colour[k], kJpegQuality)
                       : image::encode_png(layer == scan::Layer::kDepth
                                               ? draw::colour_depth(panorama.depth[k], farthest)
                                               : draw::colour_ids(panorama.classes[k])));
  }
  return files;
}

}  // namespace

Faces::Faces(const scan::PanoramaSet& panoramas, std::size_t most_bytes)
    : panoramas_(panoramas), most_bytes_(most_bytes) {}

FaceFiles Faces::get(ScanIndex scan, ViewpointIndex viewpoint, scan::Layer layer) {
  const Key key{scan, viewpoint, layer};
  std::promise<FaceFiles> promise;
  std::shared_future<FaceFiles> files;
  bool first = false;
  {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key);
    first = found == entries_.end();
    if (first) {
      files = promise.get_future().share();
      by_use_.push_front(key);
      entries_.emplace(key, Entry{files, 0, by_use_.begin()});
    } else {
      files = found->second.files;
      by_use_.splice(by_use_.begin(), by_use_, found->second.use);
    }
  }
  if (!first) return files.get();
  try {
    promise.set_value(make_files(panoramas_.source(scan), viewpoint, layer));
    add_bytes(key, files.get());
  } catch (...) {  // requests that wait get the exception too; later ones try again
    promise.set_exception(std::current_exception());
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key);
    by_use_.erase(found->second.use);
    entries_.erase(found);
  }
  return files.get();
}

void Faces::add_bytes(const Key& key, const FaceFiles& files) {
  const std::scoped_lock lock(mutex_);
  Entry& entry = entries_.find(key)->second;
  for (const auto& file : files) entry.bytes += file->size();
  bytes_ += entry.bytes;
  // Entries that are being made count as 0 bytes, and must stay until they are filled.
  for (auto use = by_use_.end(); bytes_ > most_bytes_ && use != by_use_.begin();) {
    const auto oldest = entries_.find(*--use);
    if (oldest->second.bytes == 0 || oldest->first == key) continue;
    bytes_ -= oldest->second.bytes;
    entries_.erase(oldest);
    use = by_use_.erase(use);
  }
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
