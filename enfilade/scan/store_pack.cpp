#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "enfilade/scan/detail/panorama_coding.h"
#include "enfilade/scan/detail/store_writer.h"
#include "enfilade/scan/store.h"

namespace enfilade::scan {
namespace {

using detail::EncodedPanorama;
using detail::PlannedPanorama;

void validate(const PackOptions& options) {
  if (options.jpeg_quality < 1 || options.jpeg_quality > 100) {
    throw ArgumentError(fmt::format("jpeg_quality: {}, not from 1 to 100", options.jpeg_quality));
  }
  if (options.threads < 0) {
    throw ArgumentError(fmt::format("threads: {}, not 0 (all) or more", options.threads));
  }
}

// What the format has no room for.
void validate(const PanoramaSource& source) {
  for (const PanoramaPose& pose : source.poses()) {
    if (!pose.viewpoint.empty() && pose.viewpoint.size() <= detail::kLongestName) continue;
    throw ArgumentError(fmt::format("scan {:?}: a viewpoint's id of {} bytes, not 1 to {}",
                                    source.scan(), pose.viewpoint.size(), detail::kLongestName));
  }
}

// 0 if the source can't tell its state. Everything that the bytes of a store depend on, but for
// the versions of the codecs.
std::uint64_t fingerprint_of(const PanoramaSource& source, const Connectivity& graph,
                             const PackOptions& options) {
  const std::string state = source.state();
  if (state.empty()) return 0;
  const std::string all = fmt::format(
      "{}\n{}\n{} {} {} {}\n{}\n{}", kStoreVersion, source.scan(), static_cast<int>(options.colour),
      options.face_size, options.jpeg_quality, options.included_only, to_json(graph), state);
  // 0 has its own meaning.
  return std::max<std::uint64_t>(1, detail::checksum(image::bytes_of(all)));
}

// The finished store of the same input, if it is there and sound.
std::shared_ptr<const Store> complete_store(const std::filesystem::path& file,
                                            std::uint64_t fingerprint) {
  if (fingerprint == 0) return nullptr;
  try {
    auto store = Store::open(file);
    return store->fingerprint() == fingerprint ? store : nullptr;
  } catch (const Error&) {  // absent, damaged, of another version: packed anew
    return nullptr;
  }
}

bool is_packed(const PanoramaPose& pose, const PackOptions& options) {
  return pose.included || !options.included_only;
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
    plan.push_back({ViewpointIndex(i), sizes[i], detail::packed_sizes(sizes[i], options)});
    colour = colour || sizes[i][index(Layer::kColour)] > 0;
    const std::uint32_t largest = std::ranges::max(plan.back().sizes);
    if (largest > detail::kLargestFace) {
      throw ArgumentError(
          fmt::format("face_size: viewpoint {:?} has faces of {} texels; a store "
                      "holds at most {}",
                      source.poses()[i].viewpoint, largest, detail::kLargestFace));
    }
  }
  if (!colour) {
    throw ArgumentError(
        fmt::format("scan {:?}: no panorama has colour in {}", source.scan(), source.origin()));
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

void write_panoramas(const PanoramaSource& source, const PackOptions& options,
                     std::span<const PlannedPanorama> plan, detail::StoreWriter& writer,
                     const Progress& progress) {
  if (progress) progress(writer.panoramas(), plan.size());
  // In windows, so that what is encoded and waits for its turn stays little; a few panoramas a
  // thread, as some take longer than others.
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
  make_folder(directory);
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
