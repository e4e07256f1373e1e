#include "enfilade/scan/detail/panorama_coding.h"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/image/cube_border.h"

namespace enfilade::scan::detail {
namespace {

using Jpegs = std::array<std::vector<std::uint8_t>, kCubeFaces>;

void append_face(EncodedPanorama& to, Layer layer, std::size_t face, const CodedFace& coded,
                 const std::vector<std::uint8_t>& border) {
  FaceEntry& entry = to.header.faces[entry_index(layer, face)];
  entry.offset = to.payload.size();
  entry.bytes = static_cast<std::uint32_t>(coded.bytes.size());
  entry.border_bytes = static_cast<std::uint32_t>(border.size());
  entry.coding = coded.coding;
  to.payload.insert(to.payload.end(), coded.bytes.begin(), coded.bytes.end());
  to.payload.insert(to.payload.end(), border.begin(), border.end());
  entry.checksum =
      checksum(image::Bytes(to.payload).subspan(entry.offset, to.payload.size() - entry.offset));
}

// The texel in the middle of each area.
template <class T>
image::CubeMap<T> resampled(image::CubeMap<T> map, std::uint32_t size) {
  const std::uint32_t from = map[0].width;
  if (from == size) return map;
  image::CubeMap<T> result;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    result[k] = image::Image<T>(size, size, 1);
    for (std::size_t y = 0; y < size; ++y) {
      for (std::size_t x = 0; x < size; ++x) {
        *result[k].at(x, y) = *map[k].at((2 * x + 1) * from / (2 * std::size_t{size}),
                                         (2 * y + 1) * from / (2 * std::size_t{size}));
      }
    }
  }
  return result;
}

template <class T>
void append_texels(EncodedPanorama& to, Layer layer, image::CubeMap<T> map) {
  map = resampled(std::move(map), to.header.sizes[index(layer)]);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    append_face(to, layer, k, encode_texels<T>(map[k].pixels, map[k].width), {});
  }
}

// The source's own JPEGs if they are wanted, there, and of the size planned.
std::optional<Jpegs> kept_jpegs(const PanoramaSource& source, const PlannedPanorama& planned,
                                const PackOptions& options) {
  constexpr std::size_t kColour = index(Layer::kColour);
  if (options.colour != ColourCoding::kKeep ||
      planned.source_sizes[kColour] != planned.sizes[kColour]) {
    return std::nullopt;
  }
  const auto texts = source.colour_jpegs(planned.viewpoint);
  if (!texts) return std::nullopt;
  Jpegs jpegs;
  for (std::size_t k = 0; k < kCubeFaces; ++k)
    jpegs[k].assign((*texts)[k].begin(), (*texts)[k].end());
  return jpegs;
}

image::CubeMap<std::uint8_t> shrunk(image::CubeMap<std::uint8_t> faces, std::uint32_t size) {
  if (faces[0].width != size) {
    for (image::Image8& face : faces) face = image::shrink(face, size, size);
  }
  return faces;
}

Jpegs encoded(const image::CubeMap<std::uint8_t>& faces, int quality) {
  // From here on colours that bleed would be what one sees first.
  constexpr int kFullChromaQuality = 90;
  Jpegs jpegs;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    jpegs[k] = image::encode_jpeg(faces[k], quality, quality >= kFullChromaQuality);
  }
  return jpegs;
}

image::CubeMap<std::uint8_t> decoded(const Jpegs& jpegs, const PanoramaSource& source,
                                     const PlannedPanorama& planned) {
  const std::uint32_t size = planned.sizes[index(Layer::kColour)];
  const std::string& viewpoint = source.poses()[planned.viewpoint.at()].viewpoint;
  image::CubeMap<std::uint8_t> faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const std::string where = fmt::format("viewpoint {:?}, colour, face {}", viewpoint, k);
    faces[k] = image::decode_jpeg(jpegs[k], source.origin() + ": " + where);
    if (faces[k].width == size && faces[k].height == size) continue;
    throw InvalidInput({{Severity::kError, source.origin(), where, "wrong-size",
                         fmt::format("{} x {} pixels, not {} x {}", faces[k].width, faces[k].height,
                                     size, size)}});
  }
  return faces;
}

void append_colour(EncodedPanorama& to, const PanoramaSource& source,
                   const PlannedPanorama& planned, const PackOptions& options) {
  std::optional<Jpegs> jpegs = kept_jpegs(source, planned, options);
  image::CubeMap<std::uint8_t> faces;
  if (!jpegs) {
    constexpr LayerMask kColourOnly = 1 << index(Layer::kColour);
    faces = shrunk(read_panorama(source, planned.viewpoint, kColourOnly).colour,
                   planned.sizes[index(Layer::kColour)]);
    if (options.colour != ColourCoding::kRaw) jpegs = encoded(faces, options.jpeg_quality);
  }
  // Borders must continue what a reader will decode, not what was encoded.
  if (jpegs) faces = decoded(*jpegs, source, planned);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    CodedFace coded = jpegs ? CodedFace{Coding::kJpeg, std::move((*jpegs)[k])}
                            : CodedFace{Coding::kRawRgb, faces[k].pixels};
    append_face(to, Layer::kColour, k, coded, compress(image::border_of(faces, cube_face(k))));
  }
}

}  // namespace

FaceSizes packed_sizes(const FaceSizes& sizes, const PackOptions& options) {
  FaceSizes packed = sizes;
  if (options.face_size == 0) return packed;
  for (std::uint32_t& size : packed) size = std::min(size, options.face_size);
  return packed;
}

EncodedPanorama encode_panorama(const PanoramaSource& source, const PlannedPanorama& planned,
                                const PackOptions& options) {
  EncodedPanorama result;
  result.header.viewpoint = planned.viewpoint.value;
  result.header.sizes = planned.sizes;
  const auto has = [&](Layer layer) { return planned.sizes[index(layer)] > 0; };
  if (has(Layer::kColour)) append_colour(result, source, planned, options);
  constexpr LayerMask kNotColour = kAllLayers & ~(1 << index(Layer::kColour));
  Panorama rest = read_panorama(source, planned.viewpoint, kNotColour);
  if (has(Layer::kDepth)) append_texels(result, Layer::kDepth, std::move(rest.depth));
  if (has(Layer::kClass)) append_texels(result, Layer::kClass, std::move(rest.classes));
  if (has(Layer::kInstance)) append_texels(result, Layer::kInstance, std::move(rest.instances));
  return result;
}

}  // namespace enfilade::scan::detail
