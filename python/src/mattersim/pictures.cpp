#include "python/src/mattersim/pictures.h"

#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <mutex>
#include <new>
#include <system_error>
#include <tuple>
#include <utility>

#include "enfilade/core/gzip.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/sim/observe.h"
#include "python/src/mattersim/simulator.h"

namespace enfilade::python::mattersim {
namespace {

// Bytes of a decoded panorama of 512-texel faces, with and without depth.
constexpr std::size_t kPanoramaBytes = 6 * 1'060'000;
constexpr std::size_t kDepthBytes = 6 * 530'000;

std::shared_ptr<std::byte[]> zeros(std::size_t bytes) {
  std::shared_ptr<std::byte[]> memory(static_cast<std::byte*>(std::calloc(bytes + 1, 1)),
                                      std::free);
  if (!memory) throw std::bad_alloc();
  return memory;
}

std::size_t cache_bytes(const Settings& settings) {
  if (settings.preloading) return std::numeric_limits<std::size_t>::max();
  const std::size_t panorama = kPanoramaBytes + (settings.depth ? kDepthBytes : 0);
  return std::max<std::size_t>(settings.cache_panoramas, 1) * panorama;
}

// The result of make(): one object per key, shared as long as a caller keeps it.
template <class Key, class Make>
auto shared_by(const Key& key, const Make& make) {
  using Shared = decltype(make());
  static std::mutex mutex;
  static std::map<Key, typename Shared::weak_type> kept;
  const std::scoped_lock lock(mutex);
  auto& slot = kept[key];
  Shared found = slot.lock();
  if (!found) slot = found = make();
  return found;
}

std::shared_ptr<render::FaceCache> shared_faces(
    const std::shared_ptr<const scan::PanoramaSet>& panoramas, std::size_t bytes,
    bool with_other_processes) {
  return shared_by(std::tuple(panoramas.get(), bytes, with_other_processes), [&] {
    // Without the prefetch thread, which would not survive a fork.
    render::FaceCacheConfig config{.bytes = bytes, .prefetch_thread = false};
    if (with_other_processes) config.shared.emplace();
    return std::make_shared<render::FaceCache>(panoramas, config);
  });
}

}  // namespace

Pictures::Pictures(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                   const Settings& settings, const Options& options)
    : camera_{static_cast<std::uint32_t>(settings.width),
              static_cast<std::uint32_t>(settings.height),
              Radians(settings.vertical_field_of_view)},
      with_depth_(settings.depth),
      agents_(settings.batch_size),
      views_(settings.batch_size) {
  validate(camera_);
  faces_ = shared_faces(panoramas, cache_bytes(settings), options.shared_cache);
  render::RendererConfig config;
  config.legacy = {!options.smooth_edges, options.eight_bit_depth};
  renderer_ = render::make_renderer(faces_, config);
  const std::size_t pixels = std::size_t{camera_.width} * camera_.height * agents_;
  colour_ = zeros(pixels * 3);
  depth_ = zeros(pixels * 2);
}

void Pictures::draw(const sim::StateSpans& state) {
  sim::views_of(state, views_);
  const std::size_t pixels = std::size_t{camera_.width} * camera_.height * agents_;
  render::Outputs outputs;
  outputs.colour = {render::ColourFormat::kBgr8, {}, {colour_.get(), pixels * 3}};
  if (with_depth_) {
    outputs.depth = {render::DepthFormat::kQuarterMillimetresUint16,
                     render::DepthMeasure::kZ,
                     {depth_.get(), pixels * 2}};
  }
  renderer_->render(camera_, views_, outputs);
}

void Pictures::preload(ScanIndex scan, const std::vector<ViewpointIndex>& viewpoints) {
  std::vector<render::FaceKey> keys;
  for (const ViewpointIndex viewpoint : viewpoints) {
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      keys.push_back({scan, viewpoint, scan::Layer::kColour, cube_face(k)});
      if (with_depth_) keys.push_back({scan, viewpoint, scan::Layer::kDepth, cube_face(k)});
    }
  }
  std::vector<render::Face> faces(keys.size());
  faces_->acquire(keys, faces);
  faces_->release(keys);
}

Pixels Pictures::colour_of(std::size_t agent) const {
  const std::size_t bytes = std::size_t{camera_.width} * camera_.height * 3;
  return {colour_, agent * bytes, camera_.width, camera_.height, 3, 1};
}

Pixels Pictures::depth_of(std::size_t agent) const {
  const std::size_t bytes = std::size_t{camera_.width} * camera_.height * 2;
  return {depth_, agent * bytes, camera_.width, camera_.height, 1, 2};
}

std::shared_ptr<const scan::PanoramaSet> open_panoramas(const std::string& dataset_path,
                                                        const std::string& nav_graph_path,
                                                        const std::vector<std::string>& scans) {
  return shared_by(std::tuple(dataset_path, nav_graph_path, scans), [&] {
    return scan::PanoramaSet::open({{dataset_path}, nav_graph_path}, scans);
  });
}

namespace {

// Never freed: Python ends before static objects are destroyed. Guarded by the GIL.
using Registry = std::map<std::pair<std::string, std::string>, std::shared_ptr<SharedGraphs>>;
Registry& registry() {
  static auto* kept = new Registry;
  return *kept;
}

// Paths are relative to the current working directory, as in the old simulator.
std::string absolute(const std::string& folder) {
  std::error_code error;
  const auto path = std::filesystem::canonical(folder, error);
  return error ? folder : path.string();
}

std::string state_of(const std::filesystem::path& file) {
  std::error_code error;
  const auto time = std::filesystem::last_write_time(file, error).time_since_epoch().count();
  return error ? "" : std::to_string(time);
}

nb::object text(const std::string& s) {
  return own(PyUnicode_FromStringAndSize(s.data(), static_cast<Py_ssize_t>(s.size())));
}

}  // namespace

SharedGraphs::SharedGraphs(std::shared_ptr<const graph::GraphSet> set)
    : set_(std::move(set)), names_(set_->size()) {
  for (const std::string& scan : set_->scans()) scan_names_.push_back(text(scan));
}

std::shared_ptr<SharedGraphs> SharedGraphs::of_folder(const std::string& folder) {
  const std::string path = absolute(folder);
  auto& kept = registry()[{path, state_of(std::filesystem::path(path) / "scans.txt")}];
  if (!kept) kept = std::make_shared<SharedGraphs>(graph::GraphSet::open(path));
  return kept;
}

std::shared_ptr<SharedGraphs> SharedGraphs::of_scan(const std::string& folder,
                                                    const std::string& scan) {
  const std::string path = absolute(folder);
  scan::require_scan_id(scan);
  const auto file = find_text_file(scan::connectivity_file(path, scan));
  auto& kept = registry()[{file.string(), state_of(file)}];
  if (!kept) {
    std::vector<graph::NavGraph> graphs;
    graphs.emplace_back(scan::load_connectivity(path, scan));
    kept = std::make_shared<SharedGraphs>(graph::GraphSet::of(std::move(graphs)));
  }
  return kept;
}

const std::vector<ViewpointNames>& SharedGraphs::names(ScanIndex scan) {
  std::vector<ViewpointNames>& names = names_[scan.at()];
  const graph::NavGraph& graph = set_->graph(scan);
  if (!names.empty() || graph.size() == 0) return names;
  names.reserve(graph.size());
  const auto number = [](float value) {
    return own(PyFloat_FromDouble(static_cast<double>(value)));
  };
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex v(i);
    const Vec3f p = graph.position(v);
    names.push_back(
        {text(graph.id(v)), own(PyLong_FromSize_t(i)), number(p.x), number(p.y), number(p.z)});
  }
  return names;
}

}  // namespace enfilade::python::mattersim
