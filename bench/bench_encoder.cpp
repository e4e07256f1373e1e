// Vision Transformers on pictures of 640 x 480, with random weights, beside the time that their
// matrix products take alone, measured in the same run. Machines are shared: of both the shortest
// processor time of one thread is told, which neighbours disturb least.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <limits>
#include <vector>

#include "bench/products.h"
#include "enfilade/core/rng.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/encoder.h"

namespace enfilade {
namespace {

using bench::Product;

double milliseconds_of_processor() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

// Of n pictures through 12 blocks of width 768 with 12 heads, the last of which computes one token.
bench::ProductLog products(std::int64_t n, std::int64_t patch) {
  constexpr std::int64_t kWidth = 768, kHidden = 3072, kBlocks = 12, kHeads = 12, kSide = 224;
  const std::int64_t patches = (kSide / patch) * (kSide / patch), tokens = patches + 1;
  bench::ProductLog log;
  const auto add = [&](std::int64_t rows, std::int64_t columns, std::int64_t inner) {
    log.push_back({rows, columns, inner, false, true, false});
  };
  add(n * patches, kWidth, 3 * patch * patch);
  for (std::int64_t block = 0; block < kBlocks; ++block) {
    const std::int64_t rows = block + 1 == kBlocks ? 1 : tokens;
    add(n * tokens, 3 * kWidth, kWidth);
    for (std::int64_t head = 0; head < n * kHeads; ++head) {
      add(rows, tokens, kWidth / kHeads);
      add(rows, kWidth / kHeads, tokens);
    }
    add(n * rows, kWidth, kWidth);
    add(n * rows, kHidden, kWidth);
    add(n * rows, kWidth, kHidden);
  }
  return log;
}

void encode(benchmark::State& state, const char* name, std::size_t n) {
  neural::set_threads(1);
  const auto encoder = neural::make_encoder({.name = name});
  const Camera camera = encoder->camera();
  Rng rng(1);
  std::vector<float> pictures(n * 3 * camera.width * camera.height);
  for (float& value : pictures) value = static_cast<float>(rng.below(256));
  std::vector<float> features(n * encoder->dimensions());
  const auto log =
      products(static_cast<std::int64_t>(n), name == std::string("clip-vit-b-32") ? 32 : 16);
  const bench::ProductTimer alone(log);
  alone.run();  // its pages are fetched now
  double whole = std::numeric_limits<double>::infinity(), least = whole, operations = 0;
  for (const Product& product : log) operations += product.operations();
  for (auto _ : state) {
    const double start = milliseconds_of_processor();
    encoder->encode(pictures, n, camera, features);
    const double end = milliseconds_of_processor();
    alone.run();
    least = std::min(least, milliseconds_of_processor() - end);
    whole = std::min(whole, end - start);
    state.SetIterationTime((end - start) / 1e3);
  }
  state.counters["view_ms"] = whole / static_cast<double>(n);
  state.counters["products_ms"] = least / static_cast<double>(n);
  state.counters["ratio"] = whole / least;
  state.counters["gflop"] = operations * 1e-9 / static_cast<double>(n);
}

void register_all() {
  for (const char* name : {"vit-b-16", "clip-vit-b-16", "clip-vit-b-32"}) {
    for (const std::size_t n : {std::size_t{1}, std::size_t{4}, std::size_t{12}}) {
      benchmark::RegisterBenchmark(fmt::format("encode/{}/{}", name, n).c_str(),
                                   [=](benchmark::State& state) { encode(state, name, n); })
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace
}  // namespace enfilade

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  enfilade::register_all();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
