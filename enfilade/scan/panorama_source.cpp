#include "enfilade/scan/panorama_source.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <algorithm>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/names.h"

namespace enfilade::scan {
namespace {

template <class T>
bool is_empty(const image::CubeMap<T>& map) {
  return std::ranges::all_of(map, [](const auto& f) { return f.pixels.empty() && f.width == 0; });
}

template <class T>
void check_map(const image::CubeMap<T>& map, std::uint32_t channels, Layer layer,
               const std::string& viewpoint) {
  if (is_empty(map)) return;
  const std::uint32_t n = map[0].width;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const auto& f = map[k];
    if (n > 0 && f.width == n && f.height == n && f.channels == channels &&
        f.pixels.size() == std::size_t{n} * n * channels) {
      continue;
    }
    throw ArgumentError(
        fmt::format("panoramas: viewpoint {}, {}, face {}: {} x {} pixels of {} channels in {} "
                    "values; faces must be square, as face 0 ({} pixels wide), of {} channels",
                    quote(viewpoint), to_string(layer), k, f.width, f.height, f.channels,
                    f.pixels.size(), n, channels));
  }
}

template <class T>
std::uint64_t checksum_of_faces(const image::CubeMap<T>& map, std::uint64_t seed) {
  for (const image::Image<T>& face : map) {
    seed = XXH3_64bits_withSeed(face.pixels.data(), face.pixels.size() * sizeof(T), seed);
  }
  return seed;
}

// The texels of a face, without its border.
image::Image8 rgb_of(const image::ColourCells& face) {
  image::Image8 picture(face.size, face.size, 3);
  image::plain_rgb(face.cells, face.size, picture.pixels);
  return picture;
}

image::CubeMap<std::uint8_t> read_colour_map(const PanoramaSource& source, ViewpointIndex viewpoint,
                                             std::uint32_t size) {
  std::vector<std::uint8_t> cells(kCubeFaces * image::ColourCells::bytes(size));
  ColourFaces faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    faces[k] = {cells.data() + k * image::ColourCells::bytes(size), size};
  }
  source.read_colour(viewpoint, kAllFaces, faces);
  image::CubeMap<std::uint8_t> map;
  std::ranges::transform(faces, map.begin(), rgb_of);
  return map;
}

template <class T>
std::array<T*, kCubeFaces> make_faces(image::CubeMap<T>& map, std::uint32_t size) {
  std::array<T*, kCubeFaces> buffers{};
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    map[k] = image::Image<T>(size, size, 1);
    buffers[k] = map[k].pixels.data();
  }
  return buffers;
}

}  // namespace

std::string_view to_string(Layer layer) {
  constexpr std::array<std::string_view, kLayers> kNames{"colour", "depth", "class", "instance"};
  return kNames.at(index(layer));
}

std::size_t cells_bytes(Layer layer, std::uint32_t size) noexcept {
  switch (layer) {
    case Layer::kColour:
      return image::ColourCells::bytes(size);
    case Layer::kDepth:
    case Layer::kClass:
      return image::ValueCells<std::uint16_t>::bytes(size);
    case Layer::kInstance:
      break;
  }
  return image::ValueCells<std::uint32_t>::bytes(size);
}

PanoramaSource::PanoramaSource(std::string scan, std::string origin,
                               std::vector<PanoramaPose> poses)
    : scan_(std::move(scan)), origin_(std::move(origin)), poses_(std::move(poses)) {
  by_id_.reserve(poses_.size());
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const auto [at, fresh] = by_id_.emplace(poses_[i].viewpoint, i);
    if (fresh) continue;
    throw ArgumentError(fmt::format("scan {}: viewpoint {} is number {} and number {} of {}",
                                    quote(scan_), quote(poses_[i].viewpoint), at->second.at(), i,
                                    origin_));
  }
}

std::optional<ViewpointIndex> PanoramaSource::find(std::string_view viewpoint) const {
  const auto found = by_id_.find(viewpoint);
  if (found == by_id_.end()) return std::nullopt;
  return found->second;
}

ViewpointIndex PanoramaSource::at(std::string_view viewpoint) const {
  if (const auto found = find(viewpoint)) return *found;
  throw LookupError(fmt::format("viewpoint {}: not one of the {} of scan {} in {}",
                                quote(viewpoint), size(), quote(scan_), origin_));
}

std::optional<std::array<std::string, kCubeFaces>> PanoramaSource::colour_jpegs(
    ViewpointIndex /*viewpoint*/) const {
  return std::nullopt;
}

void PanoramaSource::read_colour_rows(ViewpointIndex viewpoint, CubeFace face,
                                      image::RowRange /*rows*/,
                                      const image::ColourCells& /*buffer*/) const {
  EN_CHECK(reads_rows(viewpoint, face));  // a source that reads rows has its own function
}

void PanoramaSource::read_16(Layer layer, ViewpointIndex viewpoint, FaceMask wanted,
                             const Faces16& buffers) const {
  EN_CHECK(layer == Layer::kDepth || layer == Layer::kClass);
  read(layer, viewpoint, wanted, buffers);
}

std::string PanoramaSource::tried(Layer /*layer*/, ViewpointIndex /*viewpoint*/) const {
  return " in " + origin_;
}

LookupError PanoramaSource::lacks(Layer layer, ViewpointIndex viewpoint) const {
  return LookupError(fmt::format("scan {}, viewpoint {}: no {}{}", quote(scan_),
                                 quote(poses_.at(viewpoint.at()).viewpoint), to_string(layer),
                                 tried(layer, viewpoint)));
}

const std::uint8_t* PanoramaSource::cells(Layer layer, ViewpointIndex viewpoint,
                                          CubeFace /*face*/) const {
  EN_CHECK(has_cells(layer, viewpoint));
  return nullptr;  // a source that has cells has its own function
}

std::string PanoramaSource::state() const { return {}; }

std::vector<PanoramaPose> poses_of(const Connectivity& connectivity) {
  std::vector<PanoramaPose> poses;
  poses.reserve(connectivity.entries.size());
  std::vector<Diagnostic> faults;
  for (std::size_t i = 0; i < connectivity.entries.size(); ++i) {
    const ConnectivityEntry& entry = connectivity.entries[i];
    const Mat3d rotation = rotation_of(entry.pose);
    if (!is_rotation(rotation)) {
      faults.push_back({Severity::kError, connectivity.file, fmt::format("$[{}].pose", i),
                        "bad-pose",
                        fmt::format("viewpoint {}: the upper left 3 x 3 part is no rotation "
                                    "(orthonormal to {}, right-handed)",
                                    quote(entry.id), kRotationTolerance)});
    }
    poses.push_back({entry.id, rotation, entry.position(), entry.included});
  }
  if (!faults.empty()) throw InvalidInput(std::move(faults));
  return poses;
}

Panorama make_panorama(std::uint32_t size) {
  Panorama panorama;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    panorama.colour[k] = image::Image8(size, size, 3);
    panorama.depth[k] = panorama.classes[k] = image::Image16(size, size, 1);
    panorama.instances[k] = image::Image32(size, size, 1);
  }
  return panorama;
}

FaceSizes Panorama::sizes() const noexcept {
  return {colour[0].width, depth[0].width, classes[0].width, instances[0].width};
}

void Panorama::copy_to(Layer layer, FaceMask wanted, const FaceBuffers& buffers) const {
  switch (layer) {
    case Layer::kColour:
      return image::write_faces(colour, wanted, std::get<ColourFaces>(buffers));
    case Layer::kDepth:
      return image::copy_faces(depth, wanted, std::get<Faces16>(buffers));
    case Layer::kClass:
      return image::copy_faces(classes, wanted, std::get<Faces16>(buffers));
    case Layer::kInstance:
      return image::copy_faces(instances, wanted, std::get<Faces32>(buffers));
  }
}

Panorama read_panorama(const PanoramaSource& source, ViewpointIndex viewpoint, LayerMask layers) {
  const FaceSizes sizes = source.face_sizes(viewpoint);
  const auto size = [&](Layer layer) {
    return (layers >> index(layer) & 1) != 0 ? sizes[index(layer)] : 0;
  };
  Panorama result;
  if (const auto n = size(Layer::kColour)) result.colour = read_colour_map(source, viewpoint, n);
  if (const auto n = size(Layer::kDepth)) {
    source.read_16(Layer::kDepth, viewpoint, kAllFaces, make_faces(result.depth, n));
  }
  if (const auto n = size(Layer::kClass)) {
    source.read_16(Layer::kClass, viewpoint, kAllFaces, make_faces(result.classes, n));
  }
  if (const auto n = size(Layer::kInstance)) {
    source.read_instances(viewpoint, kAllFaces, make_faces(result.instances, n));
  }
  return result;
}

MemoryPanoramas::MemoryPanoramas(Connectivity connectivity, std::vector<Panorama> panoramas)
    : PanoramaSource(connectivity.scan, "<memory>", poses_of(connectivity)),
      connectivity_(std::move(connectivity)),
      panoramas_(std::move(panoramas)) {
  if (panoramas_.size() != size()) {
    throw ArgumentError(fmt::format("panoramas: {} of them, not {} (one for each viewpoint of {})",
                                    panoramas_.size(), size(), scan()));
  }
  for (std::size_t i = 0; i < panoramas_.size(); ++i) {
    const std::string& id = poses()[i].viewpoint;
    check_map(panoramas_[i].colour, 3, Layer::kColour, id);
    check_map(panoramas_[i].depth, 1, Layer::kDepth, id);
    check_map(panoramas_[i].classes, 1, Layer::kClass, id);
    check_map(panoramas_[i].instances, 1, Layer::kInstance, id);
  }
}

FaceSizes MemoryPanoramas::face_sizes(ViewpointIndex viewpoint) const {
  return panoramas_.at(viewpoint.at()).sizes();
}

void MemoryPanoramas::read(Layer layer, ViewpointIndex viewpoint, FaceMask wanted,
                           const FaceBuffers& buffers) const {
  const Panorama& panorama = panoramas_.at(viewpoint.at());
  if (panorama.sizes()[index(layer)] == 0) throw lacks(layer, viewpoint);
  panorama.copy_to(layer, wanted, buffers);
}

std::string MemoryPanoramas::state() const {
  std::uint64_t sum = 0;
  for (const Panorama& p : panoramas_) {
    sum = checksum_of_faces(p.colour, sum);
    sum = checksum_of_faces(p.depth, sum);
    sum = checksum_of_faces(p.classes, sum);
    sum = checksum_of_faces(p.instances, sum);
  }
  return fmt::format("{:016x}", sum);
}

}  // namespace enfilade::scan
