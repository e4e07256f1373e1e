#include "bench/render_speed.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <functional>
#include <limits>
#include <set>
#include <utility>

#include "apps/common/program.h"
#include "bench/cpu_time.h"
#include "enfilade/core/file.h"
#include "enfilade/core/threads.h"
#include "enfilade/sim/observe.h"

namespace enfilade::bench {
namespace {

using scan::Layer;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::shared_ptr<const graph::GraphSet> graphs_of(const scan::PanoramaSet& panoramas) {
  std::vector<graph::NavGraph> graphs;
  for (std::size_t s = 0; s < panoramas.size(); ++s) {
    graphs.emplace_back(panoramas.source(ScanIndex(s)).connectivity());
  }
  return graph::GraphSet::of(std::move(graphs));
}

// A grid of side x side viewpoints whose neighbours are joined.
scan::Connectivity synthetic_graph(std::size_t side) {
  constexpr double kApart = 3;
  scan::Connectivity c{"synthetic", "<memory>", {}};
  for (std::size_t i = 0; i < side * side; ++i) {
    scan::ConnectivityEntry entry;
    const std::size_t column = i % side, row = i / side;
    const double x = kApart * static_cast<double>(column), y = kApart * static_cast<double>(row);
    entry.id = fmt::format("v{}", i);
    entry.pose = {1, 0, 0, x, 0, 0, 1, y, 0, -1, 0, 1.5, 0, 0, 0, 1};
    entry.height = 1.5;
    for (std::size_t j = 0; j < side * side; ++j) {
      const auto across = static_cast<int>(i % side) - static_cast<int>(j % side);
      const auto along = static_cast<int>(i / side) - static_cast<int>(j / side);
      if (across * across + along * along == 1) entry.unobstructed.emplace_back(j);
    }
    entry.visible = entry.unobstructed;
    c.entries.push_back(std::move(entry));
  }
  return c;
}

scan::Panorama synthetic_panorama(std::size_t seed) {
  constexpr std::uint32_t kSize = 512;
  constexpr std::size_t kTexels = std::size_t{kSize} * kSize;
  std::minstd_rand random(static_cast<std::uint32_t>(seed) + 1);
  scan::Panorama panorama = scan::make_panorama(kSize);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    for (std::size_t i = 0; i < kTexels; ++i) {
      const auto bits = static_cast<std::uint32_t>(random());
      for (std::size_t c = 0; c < 3; ++c) {
        panorama.colour[k].pixels[3 * i + c] = static_cast<std::uint8_t>(bits >> (8 * c));
      }
      panorama.depth[k].pixels[i] = static_cast<std::uint16_t>(bits >> 8);
      panorama.classes[k].pixels[i] = static_cast<std::uint16_t>(bits % 41);
      panorama.instances[k].pixels[i] = bits % 300;
    }
  }
  return panorama;
}

struct ColourWord {
  const char* word;
  render::ColourFormat format;
};
constexpr std::array<ColourWord, 5> kColourWords{{{"rgb", render::ColourFormat::kRgb8},
                                                  {"bgr", render::ColourFormat::kBgr8},
                                                  {"rgba", render::ColourFormat::kRgba8},
                                                  {"f16", render::ColourFormat::kPlanarFloat16},
                                                  {"f32", render::ColourFormat::kPlanarFloat32}}};

std::vector<Layer> layers_of(const render::Outputs& outputs) {
  std::vector<Layer> layers;
  if (outputs.colour) layers.push_back(Layer::kColour);
  if (outputs.depth) layers.push_back(Layer::kDepth);
  if (outputs.classes) layers.push_back(Layer::kClass);
  if (outputs.instances) layers.push_back(Layer::kInstance);
  return layers;
}

std::size_t line_of_status(const std::string& status, const std::string& name) {
  const std::size_t at = status.find(name + ":");
  if (at == std::string::npos) return 0;
  const std::size_t digits = status.find_first_of("0123456789", at);
  std::size_t kilobytes = 0;
  std::from_chars(status.data() + digits, status.data() + status.size(), kilobytes);
  return kilobytes * 1024;
}

std::shared_ptr<render::FaceCache> cache_of(
    const std::shared_ptr<const scan::PanoramaSet>& panoramas, const Combination& c,
    const BenchSettings& settings) {
  render::FaceCacheConfig cache;
  // What is hot keeps all that it has decoded.
  cache.bytes = c.cold ? settings.cache_bytes : std::numeric_limits<std::size_t>::max() / 2;
  cache.threads = c.threads;
  cache.prefetch_thread = settings.prefetch;
  return std::make_shared<render::FaceCache>(panoramas, cache);
}

// With the cache that users have, whatever is measured.
Combination within_limit(Combination c) {
  c.cold = true;
  return c;
}

std::unique_ptr<render::Renderer> renderer_of(const std::shared_ptr<render::FaceCache>& faces,
                                              const Combination& c, const BenchSettings& settings) {
  render::RendererConfig config;
  config.backend = settings.backend;
  config.threads = c.threads;
  config.gl_device = settings.gl_device;
  config.cpu_target = settings.cpu_target;
  return render::make_renderer(faces, config);
}

using Repeat = std::size_t (*)(Drawing&);  // draws a number of frames and returns it

// By the clock, with the threads that the combination has.
Measurement time_by_clock(const Combination& combination, const BenchSettings& settings,
                          Drawing& drawing, Repeat repeat) {
  Measurement m{.combination = combination, .renderer = drawing.description(), .per_second = {}};
  repeat(drawing);  // decodes what stays decoded, and grows what grows
  const render::FaceCacheCounters before = drawing.faces().counters();
  double seconds = 0;
  std::size_t frames = 0;
  for (std::size_t i = 0; i < settings.repetitions; ++i) {
    if (combination.cold) drawing.faces().clear();
    const Clock::time_point start = Clock::now();
    const std::size_t drawn = repeat(drawing);
    const double took = seconds_since(start);
    m.per_second.push_back(static_cast<double>(drawn) / took);
    seconds += took;
    frames += drawn;
  }
  std::ranges::sort(m.per_second);
  const render::FaceCacheCounters after = drawing.faces().counters();
  const int threads = threads_or_all(combination.threads);
  m.decoding_share = static_cast<double>(after.decode_nanoseconds - before.decode_nanoseconds) /
                     1e9 / (seconds * threads);
  m.faces_per_frame =
      static_cast<double>(after.misses - before.misses + after.prefetched - before.prefetched) /
      static_cast<double>(frames);
  m.cache_bytes = after.bytes;
  return m;
}

// Processor time of a frame, of one pinned thread.
double time_one_thread(const Buildings& buildings, Combination combination, BenchSettings settings,
                       std::size_t views, Repeat repeat) {
  const PinnedThread pinned;
  combination.threads = 1;
  settings.prefetch = false;  // would decode in another thread
  Drawing drawing(buildings, combination, settings, views);
  repeat(drawing);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < settings.repetitions; ++i) {
    if (combination.cold) drawing.faces().clear();
    const double start = thread_cpu_seconds();
    const std::size_t drawn = repeat(drawing);
    least = std::min(least, (thread_cpu_seconds() - start) / static_cast<double>(drawn));
  }
  return least;
}

Measurement time_both(const Buildings& buildings, const Combination& combination,
                      const BenchSettings& settings, std::size_t views, Repeat repeat) {
  Measurement m = [&] {
    Drawing drawing(buildings, combination, settings, views);
    return time_by_clock(combination, settings, drawing, repeat);
  }();
  if (settings.backend != render::Backend::kGl && settings.backend != render::Backend::kCuda) {
    m.cpu_seconds = time_one_thread(buildings, combination, settings, views, repeat);
  }
  return m;
}

}  // namespace

std::size_t Buildings::viewpoints() const {
  std::size_t count = 0;
  for (std::size_t s = 0; s < graphs->size(); ++s) {
    count += graphs->graph(ScanIndex(s)).included_count();
  }
  return count;
}

std::uint32_t Buildings::face_size() const {
  const scan::PanoramaSource& source = panoramas->source(ScanIndex());
  for (std::size_t v = 0; v < source.size(); ++v) {
    const std::uint32_t size = source.face_sizes(ViewpointIndex(v))[index(Layer::kColour)];
    if (size > 0) return size;
  }
  throw LookupError(fmt::format("scan {} in {} has no panorama", source.scan(), source.origin()));
}

Buildings open_buildings(const scan::PanoramaPlaces& places,
                         const std::vector<std::string>& scans) {
  Buildings buildings;
  buildings.panoramas = scan::PanoramaSet::open(places, scans);
  buildings.graphs = graphs_of(*buildings.panoramas);
  buildings.origin = buildings.panoramas->source(ScanIndex()).origin();
  return buildings;
}

Buildings synthetic_buildings(std::size_t side) {
  scan::Connectivity connectivity = synthetic_graph(side);
  std::vector<scan::Panorama> panoramas;
  for (std::size_t v = 0; v < connectivity.entries.size(); ++v) {
    panoramas.push_back(synthetic_panorama(v));
  }
  Buildings buildings;
  buildings.panoramas = scan::PanoramaSet::of(
      {std::make_shared<scan::MemoryPanoramas>(std::move(connectivity), std::move(panoramas))});
  buildings.graphs = graphs_of(*buildings.panoramas);
  buildings.origin = "synthetic, in memory (nothing to decode)";
  return buildings;
}

OutputMemory::OutputMemory(const std::string& words, const Camera& camera, std::size_t views) {
  const std::size_t pixels = std::size_t{camera.width} * camera.height * views;
  for (std::size_t begin = 0; begin <= words.size();) {
    const std::size_t end = std::min(words.find('+', begin), words.size());
    add(words.substr(begin, end - begin), pixels);
    begin = end + 1;
  }
}

void OutputMemory::add(const std::string& word, std::size_t pixels) {
  const auto colour = std::ranges::find_if(
      kColourWords, [&](const ColourWord& known) { return word == known.word; });
  if (colour != kColourWords.end()) {
    if (outputs_.colour)
      throw apps::UsageError(fmt::format("--outputs: {} beside another colour", word));
    colour_.resize(pixels * render::pixel_bytes(colour->format));
    outputs_.colour = {colour->format, render::kImageNet, colour_};
  } else if (word == "depth") {
    constexpr auto kFormat = render::DepthFormat::kQuarterMillimetresUint16;
    depth_.resize(pixels * render::pixel_bytes(kFormat));
    outputs_.depth = {kFormat, render::DepthMeasure::kZ, depth_};
  } else if (word == "class") {
    constexpr auto kFormat = render::ClassFormat::kUint16;
    classes_.resize(pixels * render::pixel_bytes(kFormat));
    outputs_.classes = {kFormat, classes_};
  } else if (word == "instance") {
    instances_.resize(pixels);
    outputs_.instances = {instances_};
  } else {
    throw apps::UsageError(fmt::format(
        "--outputs: {:?} is none of rgb, bgr, rgba, f16, f32, depth, class, instance", word));
  }
}

Walk::Walk(const Buildings& buildings, const Camera& camera, std::size_t batch)
    : simulator_(buildings.graphs,
                 [&] {
                   sim::SimulatorConfig config = sim::SimulatorConfig::room_to_room();
                   config.batch_size = batch;
                   config.camera = camera;
                   return config;
                 }()),
      buffer_(batch, simulator_.config().max_navigable),
      actions_(batch),
      views_(batch) {
  std::vector<sim::EpisodeStart> starts(batch);
  for (std::size_t i = 0; i < batch; ++i) {
    const ScanIndex scan(i % buildings.graphs->size());
    const graph::NavGraph& graph = buildings.graphs->graph(scan);
    ViewpointIndex viewpoint;
    do {
      viewpoint = ViewpointIndex(random_() % graph.size());
    } while (!graph.included(viewpoint));
    starts[i] = {{scan, viewpoint}, Radians(0), Radians(0)};
  }
  simulator_.new_episodes(starts, buffer_.spans());
  look();
}

void Walk::step() {
  const sim::StateSpans state = buffer_.spans();
  const auto change = [&] { return Radians(static_cast<double>(random_() % 3) - 1); };
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    actions_[i].index = static_cast<std::uint32_t>(random_() % state.navigable_count[i]);
    actions_[i].heading_change = change();
    actions_[i].elevation_change = change();
  }
  simulator_.step(actions_, state);
  look();
}

void Walk::look() { sim::views_of(buffer_.spans(), views_); }

Drawing::Drawing(const Buildings& buildings, const Combination& combination,
                 const BenchSettings& settings, std::size_t views)
    : buildings_(buildings),
      combination_(combination),
      settings_(settings),
      memory_(combination.outputs, combination.camera, views),
      faces_(cache_of(buildings.panoramas, combination, settings)),
      renderer_(renderer_of(faces_, combination, settings)) {}

std::size_t Drawing::walk(const Look& each) {
  const Combination& c = combination_;
  Walk walk(buildings_, c.camera, c.batch);
  const std::vector<Layer> layers = layers_of(memory_.outputs());
  const std::size_t steps = std::max<std::size_t>(settings_.frames / c.batch, 1);
  for (std::size_t i = 0; i < steps; ++i) {
    if (i > 0) walk.step();
    renderer_->render(c.camera, walk.views(), memory_.outputs());
    if (settings_.prefetch) {
      sim::prefetch_neighbours(walk.state(), walk.max_navigable(), c.camera, layers, *faces_);
    }
    if (each) each(walk, memory_.outputs());
  }
  return steps * c.batch;
}

std::size_t Drawing::sweep() {
  std::size_t frames = 0;
  for (std::size_t s = 0; s < buildings_.panoramas->size(); ++s) {
    const ScanIndex scan(s);
    const graph::NavGraph& graph = buildings_.graphs->graph(scan);
    for (std::size_t v = 0; v < graph.size(); ++v) {
      if (!graph.included(ViewpointIndex(v))) continue;
      const auto views = render::discrete_views(scan, ViewpointIndex(v));
      renderer_->render(combination_.camera, views, memory_.outputs());
      frames += views.size();
    }
  }
  return frames;
}

Measurement measure(const Buildings& buildings, const Combination& combination,
                    const BenchSettings& settings) {
  return time_both(buildings, combination, settings, combination.batch,
                   [](Drawing& drawing) { return drawing.walk(); });
}

Measurement measure_sweep(const Buildings& buildings, const Combination& combination,
                          const BenchSettings& settings) {
  return time_both(buildings, combination, settings, render::kDiscreteViews,
                   [](Drawing& drawing) { return drawing.sweep(); });
}

Memory memory_now() {
  const std::string status = read_file("/proc/self/status");
  return {line_of_status(status, "RssAnon"), line_of_status(status, "RssFile"),
          line_of_status(status, "VmHWM")};
}

WalkMemory measure_walk_memory(const Buildings& buildings, const Combination& combination,
                               const BenchSettings& settings) {
  WalkMemory result;
  result.before = memory_now();
  const Combination bounded = within_limit(combination);
  Drawing drawing(buildings, bounded, settings, bounded.batch);
  std::set<std::pair<ScanIndex, ViewpointIndex>> seen;
  result.frames = drawing.walk([&](Walk& now, const render::Outputs&) {
    for (const render::View& view : now.views()) {
      seen.emplace(view.scan, view.viewpoint);
    }
    const Memory used = memory_now();
    result.most.anonymous = std::max(result.most.anonymous, used.anonymous);
    result.most.file_backed = std::max(result.most.file_backed, used.file_backed);
    result.most.peak = std::max(result.most.peak, used.peak);
  });
  result.viewpoints_seen = seen.size();
  return result;
}

void draw_first_frame(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                      const Combination& combination, const BenchSettings& settings) {
  const Combination bounded = within_limit(combination);
  const auto renderer = renderer_of(cache_of(panoramas, bounded, settings), bounded, settings);
  const OutputMemory memory(combination.outputs, combination.camera, 1);
  const scan::PanoramaSource& source = panoramas->source(ScanIndex());
  for (std::size_t v = 0; v < source.size(); ++v) {
    if (source.face_sizes(ViewpointIndex(v))[index(Layer::kColour)] == 0) continue;
    const render::View view{ScanIndex(), ViewpointIndex(v), Radians(0), Radians(0)};
    renderer->render(combination.camera, std::span(&view, 1), memory.outputs());
    return;
  }
  throw LookupError(fmt::format("scan {} in {} has no panorama", source.scan(), source.origin()));
}

}  // namespace enfilade::bench
