// bench_cuda: pictures a second into a card's own memory, beside what its memory can take.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "bench/render_speed.h"
#include "enfilade/core/file.h"
#include "enfilade/render/cuda/driver.h"
#include "enfilade/render/devices.h"

namespace enfilade::bench {
namespace {

using namespace apps;
using render::cuda::api;
using render::cuda::check;

using Json = nlohmann::ordered_json;

struct Options {
  std::vector<std::string> cases{"640x480:rgb", "640x480:rgb+depth", "224x224:f16", "224x224:rgb",
                                 "640x480:rgb+depth+class+instance"};
  std::size_t side = 8, batch = 4096;
  double seconds = 1;
  std::string json;
};

struct Case {
  Camera camera;
  std::string words;
};

Case case_of(const std::string& text) {
  Case c;
  unsigned width = 0, height = 0;
  std::array<char, 64> words{};
  if (std::sscanf(text.c_str(), "%ux%u:%63s", &width, &height, words.data()) != 3) {
    throw UsageError(
        fmt::format("--case {}: WIDTHxHEIGHT:OUTPUTS is wanted, as 640x480:rgb+depth", text));
  }
  c.camera = {width, height, degrees(60)};
  validate(c.camera);
  c.words = words.data();
  return c;
}

/// A timed stretch of a stream.
class Timer {
 public:
  explicit Timer(render::cuda::StreamHandle stream) : stream_(stream) {
    for (auto& event : events_) {
      render::cuda::EventHandle made = nullptr;
      check(api().EventCreate(&made, 0), "making an event");
      event = render::cuda::Event(made);
    }
  }
  template <class Work>
  double seconds(const Work& work) {
    check(api().EventRecord(events_[0].get(), stream_), "recording");
    work();
    check(api().EventRecord(events_[1].get(), stream_), "recording");
    check(api().EventSynchronize(events_[1].get()), "waiting");
    float milliseconds = 0;
    check(api().EventElapsedTime(&milliseconds, events_[0].get(), events_[1].get()), "timing");
    return static_cast<double>(milliseconds) / 1e3;
  }

 private:
  render::cuda::StreamHandle stream_;
  std::array<render::cuda::Event, 2> events_;
};

// Any of the panoramas, in any of the 36 discretized directions: a batch of different places; or
// whole sweeps, the 36 views of a place one after the other.
std::vector<render::View> views_of(std::size_t count, std::size_t panoramas, bool sweeps) {
  std::minstd_rand random(7);
  std::vector<render::View> views;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t place =
        sweeps ? k / render::kDiscreteViews % panoramas : random() % panoramas;
    const std::size_t direction =
        sweeps ? k % render::kDiscreteViews : random() % render::kDiscreteViews;
    const ViewpointIndex viewpoint(static_cast<std::uint32_t>(place));
    views.push_back(render::discrete_views(ScanIndex(0), viewpoint)[direction]);
  }
  return views;
}

// The outputs that OutputMemory makes, in the card's memory instead.
struct OnCard {
  std::vector<render::cuda::Memory> memory;
  render::Outputs outputs;
  std::size_t bytes = 0;
};

OnCard outputs_of(const std::string& words, const Camera& camera, std::size_t views) {
  // Of one view on the host: formats and sizes.
  const OutputMemory one(words, camera, 1);
  OnCard card;
  card.outputs = one.outputs();
  const auto place = [&](auto& output) {
    if (!output) return;
    using Value = typename std::remove_reference_t<decltype(output->pixels)>::element_type;
    const std::size_t values = output->pixels.size() * views;
    card.memory.push_back(render::cuda::allocate(values * sizeof(Value)));
    card.bytes += values * sizeof(Value);
    output->pixels = {reinterpret_cast<Value*>(card.memory.back().get()), values};
  };
  place(card.outputs.colour);
  place(card.outputs.depth);
  place(card.outputs.classes);
  place(card.outputs.instances);
  return card;
}

// Bytes a second that the card writes, all of 4 GiB.
double write_rate(Timer& timer, render::cuda::StreamHandle stream) {
  constexpr std::size_t kBytes = std::size_t{4} << 30U;
  const render::cuda::Memory memory = render::cuda::allocate(kBytes);
  double best = 0;
  for (int k = 0; k < 10; ++k) {
    const double seconds = timer.seconds(
        [&] { check(api().MemsetD32Async(memory.get(), 7, kBytes / 4, stream), "filling"); });
    best = std::max(best, static_cast<double>(kBytes) / seconds);
  }
  return best;
}

int run(const Options& o) {
  const render::CudaReport report = render::cuda_report();
  if (report.devices.empty() || report.compiler.empty()) {
    fmt::print(stderr, "bench_cuda: skipped: {}\n",
               report.devices.empty() ? report.error : report.compiler_error);
    return 0;
  }
  const std::size_t panoramas = o.side * o.side;
  const Buildings buildings = synthetic_buildings(o.side);
  const auto faces = std::make_shared<render::FaceCache>(
      buildings.panoramas, render::FaceCacheConfig{.bytes = std::size_t{256} << 20U});
  const auto renderer = render::make_renderer(faces, {.backend = render::Backend::kCuda});
  const render::cuda::Device device(0);
  const render::cuda::CurrentDevice current(device);
  const render::cuda::Stream stream = render::cuda::make_stream();
  Timer timer(stream.get());
  const double rate = write_rate(timer, stream.get());
  fmt::print(
      "{}, driver of CUDA {}, NVRTC {}\n{} panoramas of 512 texels, SYNTHETIC; batches of {}; "
      "writes alone: {:.0f} GB/s\n\n",
      renderer->description(), report.driver, report.compiler, panoramas, o.batch, rate / 1e9);
  fmt::print("{:<36}{:>8}{:>14}{:>14}{:>12}{:>14}\n", "", "views", "frames/s", "worst of 5", "GB/s",
             "of writing");
  Json rows = Json::array();
  for (const std::string& text : o.cases) {
    const Case c = case_of(text);
    for (const bool sweeps : {false, true}) {
      OnCard card = outputs_of(c.words, c.camera, o.batch);
      card.outputs.stream = render::CudaStream{stream.get()};
      const std::vector<render::View> views = views_of(o.batch, panoramas, sweeps);
      const auto draw = [&] { renderer->render(c.camera, views, card.outputs); };
      draw();  // compiles, and brings the panoramas in
      const double once = timer.seconds([&] { draw(); });
      const auto times = static_cast<int>(std::clamp(o.seconds / 5 / once, 2.0, 1e5));
      std::vector<double> rates;
      for (int k = 0; k < 5; ++k) {
        const double seconds = timer.seconds([&] {
          for (int i = 0; i < times; ++i) draw();
        });
        rates.push_back(static_cast<double>(o.batch) * times / seconds);
      }
      std::ranges::sort(rates);
      const double frames = rates[2];
      const double bytes = frames * static_cast<double>(card.bytes) / static_cast<double>(o.batch);
      fmt::print("{:<36}{:>8}{:>14.0f}{:>14.0f}{:>12.1f}{:>13.1f}%\n", text,
                 sweeps ? "sweeps" : "random", frames, rates[0], bytes / 1e9, 100 * bytes / rate);
      rows.push_back({{"case", text},
                      {"views", sweeps ? "sweeps" : "random"},
                      {"frames_per_second", frames},
                      {"worst", rates[0]},
                      {"bytes_per_second", bytes},
                      {"write_rate", rate}});
    }
  }
  if (!o.json.empty()) {
    const Json all{{"card", renderer->description()}, {"driver", report.driver},
                   {"nvrtc", report.compiler},        {"batch", o.batch},
                   {"panoramas", panoramas},          {"rows", rows}};
    write_file_atomically(o.json, all.dump(1) + "\n");
  }
  return 0;
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  using namespace enfilade::bench;
  CLI::App app(
      "Measures how many pictures a second a card of NVIDIA draws into its own memory, by its own "
      "clock; all panoramas are there already. Says so and ends where there is no card.",
      "bench_cuda");
  Options o;
  int status = kSuccess;
  app.add_option("--case", o.cases, "WIDTHxHEIGHT:OUTPUTS, outputs as of bench_render")
      ->capture_default_str();
  add_whole_number(app, "--side", o.side, "Panoramas: this number squared, of 512 texels");
  add_whole_number(app, "--batch", o.batch, "Views a call");
  app.add_option("--seconds", o.seconds, "Of each measurement")
      ->check(finite_number(0.01, 1000))
      ->capture_default_str();
  app.add_option("--json", o.json, "Write the table as JSON too")->type_name("FILE");
  set_examples(app, {"bench_cuda", "bench_cuda --case 640x480:rgb 224x224:f16 --batch 1024"});
  app.callback([&] { status = run(o); });
  return run_program(app, argc, argv, status);
}
