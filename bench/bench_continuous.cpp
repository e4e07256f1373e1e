// Pictures of a model home from places where people could stand: agent-steps a second with VLN-CE's
// two cameras (colour 224 x 224 and depth 256 x 256, 90 degrees), depth alone, and rays alone as
// the bound of what a ray tracer could do. The argument is the number of threads.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <vector>

#include "enfilade/capture/mesh_panoramas.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/homes/built_home.h"

namespace enfilade {
namespace {

using continuous::Eyes;
using continuous::MeshView;
using continuous::Method;
using continuous::Scene;

constexpr Camera kColour{224, 224, degrees(90)}, kDepth{256, 256, degrees(90)};
constexpr std::size_t kViews = 256, kBatch = 64;

struct World {
  std::shared_ptr<const mesh::RayTracer> tracer;
  std::shared_ptr<const mesh::LitMesh> light;
  std::shared_ptr<const Scene> scene;
  std::vector<MeshView> views;
  scan::Connectivity graph;
};

// Places over the floors of rooms with nothing within 0.2 m, at the height of a person's eyes.
std::vector<MeshView> places(const homes::BuiltHome& built) {
  std::vector<MeshView> views;
  Rng rng(7);
  while (views.size() < kViews) {
    const auto& rooms = built.home.plan.rooms;
    const auto& room = rooms[rng.below(rooms.size())];
    const auto within = [&](double low, double high) { return low + rng.uniform() * (high - low); };
    const double floor = built.home.plan.storeys[room.storey].floor;
    const Vec3d eye{within(room.floor.x0, room.floor.x1), within(room.floor.y0, room.floor.y1),
                    floor + 1.5};
    bool free = true;
    for (int k = 0; k < 16 && free; ++k) {
      const double a = k * kPi / 8;
      free = !built.tracer->blocked(
          {to_float(eye), to_float({std::cos(a), std::sin(a), -0.3}), 0, 0.2F});
    }
    if (!free) continue;
    views.push_back({0, eye, Radians(within(0, 2 * kPi)), Radians(0)});
  }
  return views;
}

const World& world() {
  static const World kWorld = [] {
    World made;
    homes::PlanOptions options;
    options.seed = 5;
    options.area = 260;
    homes::BuiltHome built = homes::build_home(options);
    made.tracer = built.tracer;
    made.light = std::make_shared<const mesh::LitMesh>(built.tracer, built.home.lights);
    made.scene = Scene::lit(made.tracer, *made.light);
    made.views = places(built);
    made.graph = homes::build_graph(built, "home", 0);
    std::printf("home: %zu triangles; scene: %.1f MB\n", made.tracer->mesh().triangles.size(),
                static_cast<double>(made.scene->bytes()) / 1e6);
    return made;
  }();
  return kWorld;
}

std::span<const MeshView> batch(std::size_t& at) {
  const auto taken = std::span(world().views).subspan(at, kBatch);
  at = (at + kBatch) % kViews;
  return taken;
}

const std::shared_ptr<const continuous::Photographs>& photographs() {
  static const auto kPhotographs = [] {
    mesh::CaptureOptions capture;
    capture.samples = 1;
    const auto source = std::make_shared<const capture::MeshPanoramas>(world().light, world().graph,
                                                                       256, capture, "");
    auto made = std::make_shared<const continuous::Photographs>(scan::PanoramaSet::of({source}),
                                                                ScanIndex(0), world().scene);
    made->load_all();
    return made;
  }();
  return kPhotographs;
}

void draw(benchmark::State& state, Method method, bool colour, bool depth, bool panoramas = false) {
  continuous::EyesConfig config{method, static_cast<int>(state.range(0)), {}};
  if (panoramas) config.photographs = {photographs()};
  Eyes eyes({world().scene}, config);
  std::vector<std::byte> rgb(kBatch * kColour.width * kColour.height * 3);
  std::vector<std::byte> metres(kBatch * kDepth.width * kDepth.height * 4);
  render::Outputs of_colour, of_depth;
  of_colour.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, rgb};
  of_depth.depth =
      render::DepthOutput{render::DepthFormat::kMetresFloat32, render::DepthMeasure::kZ, metres};
  std::size_t at = 0;
  for (auto _ : state) {
    const auto views = batch(at);
    if (colour) eyes.render(kColour, views, of_colour);
    if (depth) eyes.render(kDepth, views, of_depth);
  }
  state.counters["steps"] = benchmark::Counter(static_cast<double>(state.iterations()) * kBatch,
                                               benchmark::Counter::kIsRate);
}

// One view after another, as a simulator of one agent draws them: colour and depth of one camera.
void draw_one(benchmark::State& state, const Camera& camera) {
  Eyes eyes({world().scene}, {.threads = static_cast<int>(state.range(0))});
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  std::vector<std::byte> rgba(4 * pixels), metres(4 * pixels);
  render::Outputs outputs;
  outputs.colour = render::ColourOutput{render::ColourFormat::kRgba8, {}, rgba};
  outputs.depth =
      render::DepthOutput{render::DepthFormat::kMetresFloat32, render::DepthMeasure::kZ, metres};
  std::size_t at = 0;
  for (auto _ : state) {
    eyes.render(camera, std::span(world().views).subspan(at, 1), outputs);
    at = (at + 1) % kViews;
  }
  state.counters["steps"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

// Only the rays of the depth camera, in packets of squares, without anything else.
void rays_alone(benchmark::State& state) {
  std::vector<mesh::Ray> rays;
  for (const MeshView& view : std::span(world().views).first(kBatch)) {
    const PixelRays pixels = pixel_rays(kDepth, world_from_camera(view.heading, view.elevation));
    for (std::uint32_t y = 0; y < kDepth.height; y += 4) {
      for (std::uint32_t x = 0; x < kDepth.width; x += 4) {
        for (std::uint32_t k = 0; k < 16; ++k) {
          rays.push_back({to_float(view.eye), to_float(pixels.at(y + k / 4, x + k % 4))});
        }
      }
    }
  }
  std::vector<mesh::Hit> hits(rays.size());
  for (auto _ : state) {
    parallel_for(rays.size() / 1024, 8, static_cast<int>(state.range(0)),
                 [&](std::size_t begin, std::size_t end) {
                   world().tracer->trace(
                       std::span(rays).subspan(1024 * begin, 1024 * (end - begin)),
                       std::span(hits).subspan(1024 * begin, 1024 * (end - begin)));
                 });
  }
  state.counters["rays"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * static_cast<double>(rays.size()),
                         benchmark::Counter::kIsRate);
}

void bake(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(Scene::lit(world().tracer, *world().light));
  }
}

BENCHMARK(rays_alone)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(draw, colour_and_depth, Method::kRaster, true, true)
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(draw, colour, Method::kRaster, true, false)
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(draw, colour_of_panoramas, Method::kRaster, true, false, true)
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(draw, depth, Method::kRaster, false, true)
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(draw_one, of_256_x_256, Camera{256, 256, degrees(90)})
    ->Arg(1)
    ->Arg(2)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(draw_one, of_640_x_480, Camera{640, 480, degrees(63.5)})
    ->Arg(1)
    ->Arg(2)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(draw, colour_and_depth_by_rays, Method::kRays, true, true)
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(draw, depth_by_rays, Method::kRays, false, true)
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(bake)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace enfilade

BENCHMARK_MAIN();
