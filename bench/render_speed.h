/// \file  How fast panoramas are drawn: what is measured, and how.
///
/// Method of the old simulator's own figures, so that ours can stand beside them: agents with
/// discretized views and an opening of 60 degrees walk at random (any navigable viewpoint or none,
/// turn and tilt by -1, 0 or 1 step), the same walk in each repetition; a repetition is timed
/// whole, its steps included. Then one pinned thread draws the same again, and its processor time
/// is taken: what other programs on the machine disturb least.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/render/renderer.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/sim/simulator.h"

namespace enfilade::bench {

/// Scans to walk in; one ScanIndex serves both sets.
struct Buildings {
  std::shared_ptr<const scan::PanoramaSet> panoramas;
  std::shared_ptr<const graph::GraphSet> graphs;
  std::string origin;  ///< for the report: "synthetic, in memory", or where they are

  std::size_t viewpoints() const;   ///< included ones of all scans
  std::uint32_t face_size() const;  ///< of the first panorama's colour, texels
};
/// \throws as scan::open_panoramas(), for each scan at once
Buildings open_buildings(const scan::PanoramaPlaces& places, const std::vector<std::string>& scans);
/// side x side viewpoints, 3 m apart, in a square, with noise-like pictures of 512 texels in all
/// layers. There is nothing to decode: a cold cache costs a copy.
Buildings synthetic_buildings(std::size_t side = 3);

/// What is drawn, as the option names it: parts of rgb, bgr, rgba, f16, f32, depth, class and
/// instance with + between; f16 and f32 are normalised as ImageNet's networks want it, depth is
/// uint16.
class OutputMemory {
 public:
  /// \throws UsageError for other words, or two that are colour
  OutputMemory(const std::string& words, const Camera& camera, std::size_t views);
  const render::Outputs& outputs() const noexcept { return outputs_; }

 private:
  void add(const std::string& word, std::size_t pixels);
  std::vector<std::byte> colour_, depth_, classes_;
  std::vector<std::uint32_t> instances_;
  render::Outputs outputs_;
};

/// The same random walk each time it is made.
class Walk {
 public:
  Walk(const Buildings& buildings, const Camera& camera, std::size_t batch);
  void step();
  std::span<const render::View> views() const noexcept { return views_; }
  /// What step() did last, by agent.
  std::span<const sim::Action> actions() const noexcept { return actions_; }
  sim::StateSpans state() noexcept { return buffer_.spans(); }
  std::size_t max_navigable() const noexcept { return simulator_.config().max_navigable; }

 private:
  void look();
  sim::Simulator simulator_;
  sim::StateBuffer buffer_;
  std::mt19937 random_{12345};
  std::vector<sim::Action> actions_;
  std::vector<render::View> views_;
};

/// One row of the table.
struct Combination {
  Camera camera;
  std::string outputs;
  std::size_t batch = 1;
  int threads = 0;
  bool cold = false;  ///< nothing is decoded when a repetition starts
};

struct BenchSettings {
  render::Backend backend = render::Backend::kCpu;
  std::string gl_device;
  std::string cpu_target = {};  ///< as RendererConfig's
  std::size_t frames = 600, repetitions = 5;
  std::size_t cache_bytes = render::FaceCacheConfig().bytes;  ///< of cold runs; hot ones keep all
  bool prefetch = false;  ///< the faces of neighbours, after each step
};

struct Measurement {
  Combination combination;
  std::string renderer;            ///< its description
  std::vector<double> per_second;  ///< frames, one a repetition, ascending
  double decoding_share = 0;       ///< of the threads' time, over all repetitions
  double cpu_seconds = 0;          ///< a frame, of one pinned thread, least of the repetitions;
                                   ///< 0 for back ends that have threads of their own
  double faces_per_frame = 0;      ///< decoded
  std::size_t cache_bytes = 0;     ///< in memory at the end
  double median() const { return per_second[per_second.size() / 2]; }
};

/// A renderer with a cache of its own, and memory for what it draws.
class Drawing {
 public:
  /// \param views the most that one call of the renderer draws
  Drawing(const Buildings& buildings, const Combination& combination, const BenchSettings& settings,
          std::size_t views);
  /// The whole walk, from the same start each time; `each`, where given, sees every step's views
  /// and what was drawn. Returns how many frames.
  using Look = std::function<void(Walk& walk, const render::Outputs& outputs)>;
  std::size_t walk(const Look& each = {});
  /// All 36 views of every panorama. Likewise.
  std::size_t sweep();
  render::FaceCache& faces() noexcept { return *faces_; }
  std::string description() const { return renderer_->description(); }

 private:
  const Buildings& buildings_;
  Combination combination_;
  const BenchSettings& settings_;
  OutputMemory memory_;
  std::shared_ptr<render::FaceCache> faces_;
  std::unique_ptr<render::Renderer> renderer_;
};

Measurement measure(const Buildings& buildings, const Combination& combination,
                    const BenchSettings& settings);

/// All 36 views of every panorama, one after the other, each repetition from a cold cache.
Measurement measure_sweep(const Buildings& buildings, const Combination& combination,
                          const BenchSettings& settings);

/// Of /proc/self/status, bytes; 0 where the system has no such line.
struct Memory {
  std::size_t anonymous = 0, file_backed = 0, peak = 0;  ///< RssAnon, RssFile, VmHWM
};
Memory memory_now();

struct WalkMemory {
  Memory before, most;  ///< after opening the scan; the largest of each while walking
  std::size_t frames = 0, viewpoints_seen = 0;
};
/// Walks with settings.cache_bytes.
WalkMemory measure_walk_memory(const Buildings& buildings, const Combination& combination,
                               const BenchSettings& settings);

/// One frame at the first viewpoint that has pictures.
void draw_first_frame(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                      const Combination& combination, const BenchSettings& settings);

}  // namespace enfilade::bench
