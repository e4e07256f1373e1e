#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/names.h"
#include "enfilade/core/output_folder.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/image/jpeg_rows.h"
#include "enfilade/scan/detail/face_coding.h"
#include "enfilade/scan/detail/store_format.h"
#include "enfilade/scan/store.h"

namespace enfilade::scan {
namespace {

using detail::CodedFace;
using detail::Coding;
using detail::EncodedPanorama;
using detail::FaceEntry;
using detail::PlannedPanorama;

void validate(const PackOptions& options) {
  if (options.jpeg_quality < 1 || options.jpeg_quality > 100) {
    throw ArgumentError(fmt::format("jpeg_quality: {}, not from 1 to 100", options.jpeg_quality));
  }
  if (options.threads < 0) {
    throw ArgumentError(fmt::format("threads: {}, not 0 (all) or more", options.threads));
  }
}

void validate(const PanoramaSource& source) {
  for (const PanoramaPose& pose : source.poses()) {
    const std::string fault = fault_of_id(pose.viewpoint);
    if (fault.empty()) continue;
    throw ArgumentError(fmt::format("scan {}: a viewpoint: {}", quote(source.scan()), fault));
  }
}

// A hash of everything that the bytes of a store depend on, except for the versions of the codecs;
// 0 if the source cannot tell its state.
std::uint64_t fingerprint_of(const PanoramaSource& source, const Connectivity& graph,
                             const PackOptions& options) {
  const std::string state = source.state();
  if (state.empty()) return 0;
  const bool jpegs = options.colour != ColourCoding::kRaw;
  const char* coding = options.decoded ? " decoded" : (jpegs ? " rows" : "");
  const std::string all =
      fmt::format("{}\n{}\n{} {} {} {}{}\n{}\n{}", kStoreVersion, source.scan(),
                  static_cast<int>(options.colour), options.face_size, options.jpeg_quality,
                  options.included_only, coding, to_json(graph), state);
  // 0 means unknown.
  return std::max<std::uint64_t>(1, detail::checksum(image::bytes_of(all)));
}

// The finished store of the same input, if it is there and sound.
std::shared_ptr<const Store> complete_store(const std::filesystem::path& file,
                                            std::uint64_t fingerprint) {
  if (fingerprint == 0) return nullptr;
  try {
    auto store = Store::open(file);
    return store->fingerprint() == fingerprint ? store : nullptr;
  } catch (const Error&) {  // absent, damaged or of another version: pack it again
    return nullptr;
  }
}

bool is_packed(const PanoramaPose& pose, const PackOptions& options) {
  return pose.included || !options.included_only;
}

// Sizes of the faces in the store: those of the source, none above options.face_size.
FaceSizes packed_sizes(const FaceSizes& sizes, const PackOptions& options) {
  FaceSizes packed = sizes;
  if (options.face_size == 0) return packed;
  for (std::uint32_t& size : packed) size = std::min(size, options.face_size);
  return packed;
}

std::vector<PlannedPanorama> make_plan(const PanoramaSource& source, const PackOptions& options) {
  std::vector<FaceSizes> sizes(source.size());
  parallel_for(source.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_packed(source.poses()[i], options)) continue;
      sizes[i] = source.face_sizes(ViewpointIndex(i));
    }
  });
  std::vector<PlannedPanorama> plan;
  bool colour = false;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    if (sizes[i] == FaceSizes{}) continue;
    plan.push_back({ViewpointIndex(i), sizes[i], packed_sizes(sizes[i], options)});
    colour = colour || sizes[i][index(Layer::kColour)] > 0;
    const std::uint32_t largest = std::ranges::max(plan.back().sizes);
    if (largest > image::kLargestCellFace) {
      throw ArgumentError(
          fmt::format("face_size: viewpoint {} has faces of {} texels; a store "
                      "holds at most {}",
                      quote(source.poses()[i].viewpoint), largest, image::kLargestCellFace));
    }
  }
  if (!colour) {
    throw ArgumentError(fmt::format("scan {}: no panorama has colour in {}", quote(source.scan()),
                                    source.origin()));
  }
  return plan;
}

// Included viewpoints that have no pictures in the store.
std::vector<std::string> without_pictures(const PanoramaSource& source,
                                          const std::vector<bool>& packed) {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < packed.size(); ++i) {
    const PanoramaPose& pose = source.poses()[i];
    if (pose.included && !packed[i]) ids.push_back(pose.viewpoint);
  }
  return ids;
}

PackReport report_of(const Store& store) {
  PackReport report;
  report.file = store.origin();
  report.bytes = store.bytes();
  report.was_complete = true;
  std::vector<bool> packed(store.size());
  for (std::size_t i = 0; i < packed.size(); ++i) {
    packed[i] = store.face_sizes(ViewpointIndex(i)) != FaceSizes{};
  }
  report.panoramas = static_cast<std::size_t>(std::ranges::count(packed, true));
  report.without = without_pictures(store, packed);
  return report;
}

// --- encoding ---------------------------------------------------------------------------------

using Jpegs = std::array<std::vector<std::uint8_t>, kCubeFaces>;

void append_face(EncodedPanorama& to, Layer layer, std::size_t face, const CodedFace& coded,
                 const std::vector<std::uint8_t>& border) {
  FaceEntry& entry = to.header.faces[detail::entry_index(layer, face)];
  entry.offset = to.payload.size();
  entry.bytes = static_cast<std::uint32_t>(coded.bytes.size());
  entry.border_bytes = static_cast<std::uint32_t>(border.size());
  entry.coding = coded.coding;
  to.payload.insert(to.payload.end(), coded.bytes.begin(), coded.bytes.end());
  to.payload.insert(to.payload.end(), border.begin(), border.end());
  entry.checksum = detail::checksum(
      image::Bytes(to.payload).subspan(entry.offset, to.payload.size() - entry.offset));
}

// Depth and ids, shrunk to the texel in the middle of each area: a mean of two classes or of two
// distances would be neither.
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
CodedFace values_in_cells(const image::Image<T>& picture) {
  CodedFace coded{Coding::kCells, {}};
  coded.bytes.resize(image::ValueCells<T>::bytes(picture.width));
  image::ValueCells<T>::from_rows(picture.pixels.data(), picture.width, coded.bytes.data());
  return coded;
}

template <class T>
void append_texels(EncodedPanorama& to, Layer layer, image::CubeMap<T> map, bool decoded) {
  map = resampled(std::move(map), to.header.sizes[index(layer)]);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const CodedFace coded =
        decoded ? values_in_cells(map[k]) : detail::encode_texels<T>(map[k].pixels, map[k].width);
    append_face(to, layer, k, coded, {});
  }
}

void append_colour_cells(EncodedPanorama& to, const image::CubeMap<std::uint8_t>& faces) {
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    CodedFace coded{Coding::kCells, {}};
    coded.bytes.resize(image::ColourCells::bytes(faces[k].width));
    const image::ColourCells cells{coded.bytes.data(), faces[k].width};
    image::write_face(cells, faces[k]);
    image::write_border(cells, image::border_of(faces, cube_face(k)));
    append_face(to, Layer::kColour, k, coded, {});
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
  Jpegs jpegs;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    jpegs[k] = image::encode_jpeg(faces[k], quality, quality >= image::kFullChromaQuality);
  }
  return jpegs;
}

std::string face_of(const PanoramaSource& source, const PlannedPanorama& planned, std::size_t k) {
  return fmt::format("viewpoint {}, colour, face {}",
                     quote(source.poses()[planned.viewpoint.at()].viewpoint), k);
}

// With restart markers, which make reading quicker (image/jpeg_rows.h), where that is possible.
void mark_rows(Jpegs& jpegs, const PanoramaSource& source, const PlannedPanorama& planned) {
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    auto marked = image::mark_rows(jpegs[k], source.origin() + ": " + face_of(source, planned, k));
    if (marked) jpegs[k] = std::move(*marked);
  }
}

image::CubeMap<std::uint8_t> decoded(const Jpegs& jpegs, const PanoramaSource& source,
                                     const PlannedPanorama& planned) {
  const std::uint32_t size = planned.sizes[index(Layer::kColour)];
  image::CubeMap<std::uint8_t> faces;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const std::string where = face_of(source, planned, k);
    faces[k] = image::decode_jpeg(jpegs[k], source.origin() + ": " + where);
    if (faces[k].width == size && faces[k].height == size) continue;
    refuse(source.origin(), where, "wrong-size",
           fmt::format("{} x {} pixels, not {} x {}", faces[k].width, faces[k].height, size, size));
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
  if (jpegs && !options.decoded) mark_rows(*jpegs, source, planned);
  // Borders must match the pixels that a reader decodes, which differ from those encoded.
  if (jpegs) faces = decoded(*jpegs, source, planned);
  if (options.decoded) return append_colour_cells(to, faces);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    CodedFace coded = jpegs ? CodedFace{Coding::kJpeg, std::move((*jpegs)[k])}
                            : CodedFace{Coding::kRawRgb, faces[k].pixels};
    append_face(to, Layer::kColour, k, coded,
                detail::compress(image::border_of(faces, cube_face(k))));
  }
}

// Reads, shrinks and encodes one panorama. The same input gives the same bytes in any thread.
EncodedPanorama encode_panorama(const PanoramaSource& source, const PlannedPanorama& planned,
                                const PackOptions& options) {
  EncodedPanorama result;
  result.header.viewpoint = planned.viewpoint.value;
  result.header.sizes = planned.sizes;
  const auto has = [&](Layer layer) { return planned.sizes[index(layer)] > 0; };
  if (has(Layer::kColour)) append_colour(result, source, planned, options);
  constexpr LayerMask kNotColour = kAllLayers & ~(1 << index(Layer::kColour));
  Panorama rest = read_panorama(source, planned.viewpoint, kNotColour);
  if (has(Layer::kDepth))
    append_texels(result, Layer::kDepth, std::move(rest.depth), options.decoded);
  if (has(Layer::kClass))
    append_texels(result, Layer::kClass, std::move(rest.classes), options.decoded);
  if (has(Layer::kInstance)) {
    append_texels(result, Layer::kInstance, std::move(rest.instances), options.decoded);
  }
  return result;
}

// --- the file ---------------------------------------------------------------------------------

void write_panoramas(const PanoramaSource& source, const PackOptions& options,
                     std::span<const PlannedPanorama> plan, detail::StoreWriter& writer,
                     const Progress& progress) {
  if (progress) progress(writer.panoramas(), plan.size());
  // In windows of a few panoramas a thread (some take longer than others), so that few encoded ones
  // wait in memory to be written.
  const int threads = threads_or_all(options.threads);
  const std::size_t window = 4 * static_cast<std::size_t>(threads);
  while (writer.panoramas() < plan.size()) {
    const auto rest = plan.subspan(writer.panoramas());
    std::vector<EncodedPanorama> encoded(std::min(window, rest.size()));
    parallel_for(encoded.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        encoded[i] = encode_panorama(source, rest[i], options);
      }
    });
    for (EncodedPanorama& panorama : encoded) writer.append(std::move(panorama));
    if (progress) progress(writer.panoramas(), plan.size());
  }
}

}  // namespace

PackReport pack(const PanoramaSource& source, const std::filesystem::path& directory,
                const PackOptions& options, const Progress& progress) {
  validate(options);
  validate(source);
  PackReport report;
  report.file = store_file(directory, source.scan());
  const Connectivity graph = source.connectivity();
  const std::uint64_t fingerprint = fingerprint_of(source, graph, options);
  if (const auto store = complete_store(report.file, fingerprint)) return report_of(*store);

  const std::vector<PlannedPanorama> plan = make_plan(source, options);
  static_cast<void>(OutputFolder(directory).file(report.file.filename().string()));
  detail::StoreWriter writer(report.file, fingerprint, plan);
  report.resumed = writer.panoramas();
  write_panoramas(source, options, plan, writer, progress);
  report.bytes = writer.finish(graph);
  report.panoramas = plan.size();
  std::vector<bool> packed(source.size());
  for (const PlannedPanorama& panorama : plan) packed[panorama.viewpoint.at()] = true;
  report.without = without_pictures(source, packed);
  return report;
}

}  // namespace enfilade::scan
