// A training iteration of the sequence-to-sequence agent at the paper's sizes: 100 instructions of
// R2R's train split, 20 steps in the real graphs, made features (there are no pictures to make them
// from), dropout, Adam. Beside each iteration, in the same run, the time that its matrix products
// take alone. Machines are shared: of both the shortest time is told, and each is measured again as
// the processor's time of one thread, which neighbours disturb least.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <vector>

#include "bench/main.h"
#include "bench/products.h"
#include "enfilade/core/rng.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/seq2seq/evaluation.h"
#include "enfilade/neural/seq2seq/seq2seq.h"
#include "enfilade/scan/data_root.h"

namespace enfilade {
namespace {

using namespace features;  // NOLINT: a benchmark of its own file
using namespace models;
using namespace neural;
using namespace neural::seq2seq;

constexpr std::size_t kBatch = 100;
using Time = std::chrono::nanoseconds;

/// What time is, and how many threads work.
struct Measure {
  const char* name;
  int threads;  // 0: all cores
  Time (*now)();
};

Time clock_time(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return std::chrono::seconds(time.tv_sec) + Time(time.tv_nsec);
}
constexpr Measure kWall{"wall", 0, [] { return clock_time(CLOCK_MONOTONIC); }};
constexpr Measure kOneThread{"one_thread", 1, [] { return clock_time(CLOCK_PROCESS_CPUTIME_ID); }};

double milliseconds(Time time) { return std::chrono::duration<double, std::milli>(time).count(); }

/// R2R's episodes with features made up beforehand: rows of a table, another one at each step. Adds
/// up the time that is not the network's.
class MadeFeatures final : public Environment {
 public:
  MadeFeatures(R2rEnvironment& inner, std::size_t dimensions, const Measure& measure = kWall)
      : inner_(inner), measure_(measure), dimensions_(dimensions), table_(kRows * dimensions) {
    Rng rng(1);
    for (float& x : table_) x = static_cast<float>(rng.uniform());
  }
  std::size_t size() const override { return inner_.size(); }
  std::size_t dimensions() const override { return dimensions_; }
  bool has_teacher() const override { return inner_.has_teacher(); }
  std::span<const std::uint8_t> ended() const override { return inner_.ended(); }
  Time spent() const { return spent_; }
  bool step(std::span<const std::int32_t> actions) override {
    const auto start = measure_.now();
    const bool walking = inner_.step(actions);
    spent_ += measure_.now() - start;
    return walking;
  }
  void observe(const EnvironmentView& out) override {
    const auto start = measure_.now();
    for (std::size_t i = 0; i < size() && dimensions_ > 0; ++i) {
      next_ = (next_ + 7919) % kRows;  // a prime: every row in turn
      std::copy_n(table_.begin() + static_cast<std::ptrdiff_t>(next_ * dimensions_), dimensions_,
                  out.features.begin() + static_cast<std::ptrdiff_t>(i * dimensions_));
    }
    inner_.observe({{}, out.forward_open, out.labels});
    spent_ += measure_.now() - start;
  }

 private:
  static constexpr std::size_t kRows = 10000;  // 82 MB: no cache holds it
  R2rEnvironment& inner_;
  const Measure& measure_;
  std::size_t dimensions_, next_ = 0;
  std::vector<float> table_;
  Time spent_{};
};

struct Data {
  tasks::EpisodeSet episodes;
  tasks::Vocabulary vocabulary;
  EncodedInstructions instructions;
};

// Words from train, whatever is walked.
const Data& data(const char* split) {
  const auto make = [](const char* name) {
    const auto root = *scan::DataRoot::from_environment();
    const auto graphs = graph::GraphSet::open(root.connectivity());
    const auto load = [&](const char* one) {
      return make_episodes(tasks::load_annotations(root.annotations(one), one), graphs);
    };
    tasks::EpisodeSet episodes = load(name);
    tasks::Vocabulary vocabulary = training_vocabulary(load("train"));
    EncodedInstructions instructions(episodes, vocabulary);
    return Data{std::move(episodes), std::move(vocabulary), std::move(instructions)};
  };
  static const Data kTrain = make("train");
  static const Data kUnseen = make("val_unseen");
  return split == std::string_view("train") ? kTrain : kUnseen;
}

NetworkConfig config_for(const Data& data, bool vision) {
  NetworkConfig config;
  config.vocabulary = data.vocabulary.size();
  config.inputs.vision = vision;
  if (!vision) config.features = 0;
  return config;
}

struct Shortest {
  double value = std::numeric_limits<double>::infinity();
  void note(double x) { value = std::min(value, x); }
};

void iteration(benchmark::State& state, Feedback feedback, bool vision, const Measure& measure) {
  set_threads(measure.threads);
  const Data& train = data("train");
  Network network(config_for(train, vision), 1);
  R2rEnvironment walked(train.episodes, nullptr, {.batch_size = kBatch});
  MadeFeatures seen(walked, network.config().features, measure);
  std::vector<std::size_t> episodes(kBatch);
  std::vector<std::uint32_t> tokens(kBatch * train.instructions.max_words());
  RolloutOptions options{.feedback = feedback, .dropout = true};
  Shortest whole, products, update, environment;
  double operations = 0;
  std::unique_ptr<bench::ProductTimer> alone;
  for (auto _ : state) {
    // The same episodes again and again, so that times differ by the machine's moods alone.
    std::iota(episodes.begin(), episodes.end(), std::size_t{2000});
    train.instructions.gather(episodes, tokens);
    walked.start(episodes);
    const auto spent = seen.spent();
    bench::ProductLog log;
    std::optional<bench::ProductRecorder> recorder(log);
    const auto start = measure.now();
    benchmark::DoNotOptimize(network.rollout_with_gradients({tokens, kBatch}, seen, options).loss);
    const auto learnt = measure.now();
    network.update({});
    const auto end = measure.now();
    recorder.reset();
    state.SetIterationTime(milliseconds(end - start) / 1e3);
    whole.note(milliseconds(end - start));
    update.note(milliseconds(end - learnt));
    environment.note(milliseconds(seen.spent() - spent));
    if (!alone) {
      alone = std::make_unique<bench::ProductTimer>(log);
      alone->run();  // its pages are fetched now
      for (const bench::Product& product : log) operations += product.operations();
    }
    const auto again = measure.now();
    alone->run();
    products.note(milliseconds(measure.now() - again));
  }
  state.counters["iteration_ms"] = whole.value;
  state.counters["products_ms"] = products.value;
  state.counters["ratio"] = whole.value / products.value;
  state.counters["gflop"] = operations * 1e-9;
  state.counters["update_ms"] = update.value;
  state.counters["environment_ms"] = environment.value;
}

// All of val unseen, greedily, as an evaluation walks it.
void evaluate(benchmark::State& state, bool vision) {
  set_threads(0);
  const Data& unseen = data("val_unseen");
  Network network(config_for(unseen, vision), 1);
  R2rEnvironment walked(unseen.episodes, nullptr, {.batch_size = kBatch});
  MadeFeatures seen(walked, network.config().features);
  const std::size_t count = unseen.episodes.episodes.size();
  std::vector<std::size_t> episodes(kBatch);
  std::vector<std::uint32_t> tokens(kBatch * unseen.instructions.max_words());
  for (auto _ : state) {
    for (std::size_t begin = 0; begin < count; begin += kBatch) {
      for (std::size_t i = 0; i < kBatch; ++i) episodes[i] = (begin + i) % count;
      unseen.instructions.gather(episodes, tokens);
      walked.start(episodes);
      network.rollout({tokens, kBatch}, seen, {});
    }
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}

void register_all() {
  for (const bool vision : {true, false}) {
    const char* eyes = vision ? "vision" : "language_only";
    for (const Feedback feedback : {Feedback::kTeacher, Feedback::kSample}) {
      for (const Measure* measure : {&kWall, &kOneThread}) {
        benchmark::RegisterBenchmark(
            fmt::format("iteration/{}/{}/{}", to_string(feedback), eyes, measure->name).c_str(),
            [=](benchmark::State& state) { iteration(state, feedback, vision, *measure); })
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
      }
    }
    benchmark::RegisterBenchmark(fmt::format("evaluate/{}", eyes).c_str(),
                                 [=](benchmark::State& state) { evaluate(state, vision); })
        ->UseRealTime()
        ->Unit(benchmark::kSecond);
  }
}

}  // namespace
}  // namespace enfilade

int main(int argc, char** argv) { return enfilade::bench::run(argc, argv, enfilade::register_all); }
