// An iteration of DUET's pretraining, by task, and of its training, with a walk behind the teacher
// and one of its own: 32 or 16 episodes of R2R's train split, made features of 128 numbers (there
// are no pictures to make them from), the sizes of duet-s. Beside the time, the shares of making
// the batch (or of environment and maps) and of the matrix products; both are from the same
// iterations, so that neighbours on the machine disturb them alike. Where there is a card, training
// there too, of the published sizes as well: beside the time that of the same products alone.
#include <ATen/ATen.h>
#include <ATen/core/grad_mode.h>
#include <ATen/record_function.h>
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "bench/main.h"
#include "enfilade/agents/panorama.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/core/learner.h"
#include "enfilade/neural/core/optimizer.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/duet/pretraining_tasks.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/neural/train.h"
#include "tests/support/feature_files.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace {

using namespace neural::duet;  // NOLINT: a benchmark of that folder
using Clock = std::chrono::steady_clock;

constexpr std::size_t kBatch = 32, kTrained = 16;
constexpr std::size_t kFirst = 2000;  // of the episodes
constexpr std::int64_t kImage = 128;

double seconds(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

// Time in libtorch's products, those of the backward pass too.
class ProductClock {
 public:
  static Clock::duration& spent() {
    static Clock::duration time{};
    return time;
  }
  static void install() {
    at::addGlobalCallback(
        at::RecordFunctionCallback(&begin, &end).scopes({at::RecordScope::FUNCTION}));
  }

 private:
  struct Began : at::ObserverContext {
    Clock::time_point at = Clock::now();
  };
  static std::unique_ptr<at::ObserverContext> begin(const at::RecordFunction& function) {
    const std::string_view name = function.name();
    for (const char* product :
         {"aten::mm", "aten::addmm", "aten::addmm_", "aten::bmm", "aten::baddbmm"}) {
      if (name == product) return std::make_unique<Began>();
    }
    return nullptr;
  }
  static void end(const at::RecordFunction&, at::ObserverContext* context) {
    if (context != nullptr) spent() += Clock::now() - static_cast<Began*>(context)->at;
  }
};

class MadeSurroundings : public Surroundings {
 public:
  void views(const graph::NavGraph&, ViewpointIndex viewpoint, std::span<float> out) override {
    Rng rng(viewpoint.value);
    for (float& value : out) value = static_cast<float>(rng.uniform() - 0.5);
  }
};

struct Data {
  tasks::EpisodeSet episodes;
  models::InstructionWords words;
  std::vector<RolloutEpisode> batch;
};

const Data& data() {
  static const Data kData = [] {
    const auto root = *dataset::Dataset::from_environment();
    tasks::EpisodeSet episodes = make_episodes(root.annotations("train"), root.graphs());
    models::InstructionWords words(models::training_vocabulary(episodes));
    std::vector<RolloutEpisode> batch;
    for (std::size_t i = kFirst; i < kFirst + kBatch; ++i) {
      const tasks::Episode& one = episodes.episodes[i];
      const tasks::ReferencePath& path = episodes.path_of(one);
      batch.push_back({one.instruction_id, path.scan, path.viewpoints.front(),
                       agents::level_view(path.heading), words.encode(one.text, 200),
                       path.viewpoints, ""});
    }
    return Data{std::move(episodes), std::move(words), std::move(batch)};
  }();
  return kData;
}

DuetConfig sizes() {
  DuetConfig config = models::duet_preset("duet-s");
  config.image = kImage;
  config.vocabulary = static_cast<std::int64_t>(data().words.size());
  return config;
}

void iteration(benchmark::State& state, PretrainingTask task, int threads) {
  neural::set_threads(threads);
  const DuetConfig config = sizes();
  const PretrainingNetwork network(config, 1);
  MadeSurroundings surroundings;
  RolloutRunner runner(data().episodes.graphs, surroundings);
  neural::core::WeightOptimizer optimizer{neural::core::OptimizerConfig()};
  const auto make = [&] {
    return pretraining_batch(runner, config, data().words, data().batch, task, {});
  };
  make();  // what it knows of viewpoints is kept
  double whole = 0, batches = 0, updates = 0;
  ProductClock::spent() = {};
  Clock::duration products{};
  for (auto _ : state) {
    const auto begin = Clock::now();
    const PretrainingBatch batch = make();
    const auto made = Clock::now();
    const auto before = ProductClock::spent();
    RateDropout dropout(1, config.dropout);
    pretraining_loss(network, batch, &dropout).backward();
    products += ProductClock::spent() - before;
    const auto learnt = Clock::now();
    optimizer.update(network.weights());
    const auto end = Clock::now();
    state.SetIterationTime(seconds(end - begin));
    whole += seconds(end - begin);
    batches += seconds(made - begin);
    updates += seconds(end - learnt);
  }
  state.counters["products"] = seconds(products) / whole;
  state.counters["batch"] = batches / whole;
  state.counters["update"] = updates / whole;
}

// The first of the batch's episodes alone.
tasks::EpisodeSet first_episodes(std::size_t n) {
  tasks::EpisodeSet chosen = data().episodes;
  chosen.episodes.clear();
  std::vector<tasks::ReferencePath> paths;
  for (std::size_t i = kFirst; i < kFirst + n; ++i) {
    tasks::Episode episode = data().episodes.episodes[i];
    paths.push_back(data().episodes.path_of(episode));
    episode.path = paths.size() - 1;
    chosen.episodes.push_back(std::move(episode));
  }
  chosen.paths = std::move(paths);
  return chosen;
}

// What `enfilade train` updates, on the same episodes again and again: one rollout along the
// annotated path, one of its own.
class Training {
 public:
  Training(const char* sizes, std::int64_t image, std::size_t episodes,
           c10::Device device = c10::kCPU) {
    config_.duet = models::duet_preset(sizes);
    config_.duet.image = image;
    config_.network.vocabulary = data().words.size();
    config_.network.features = static_cast<std::size_t>(image);
    config_.batch_size = episodes;
    config_.evaluate_every = 0;
    neural::GraphData& own = data_.graph();
    own.training = first_episodes(episodes);
    const auto file = folder_.path() / "features.safetensors";
    Rng rng(1);
    tests::write_feature_file(file, config_.network.features, tests::keys_of(own.training),
                              [&](const features::FeatureKey&, std::span<float> out) {
                                for (float& x : out) x = static_cast<float>(rng.uniform() - 0.5);
                              });
    own.features = features::FeatureSet::open(file);
    learner_ = neural::core::make_duet_learner({config_, data().words, device});
    learner_->prepare(data_, alone_);
  }

  // The seconds in environment and maps.
  double update() { return learner_->update(iteration_++).data_seconds; }

 private:
  tests::TemporaryFolder folder_{"bench_duet"};
  models::TrainConfig config_ = models::recipe(models::AgentKind::kDuet);
  neural::TrainingData data_;
  neural::Ranks alone_;
  std::unique_ptr<neural::core::Learner> learner_;
  std::uint64_t iteration_ = 0;
};

void training(benchmark::State& state, int threads) {
  neural::set_threads(threads);
  Training training("duet-s", kImage, kTrained);
  training.update();  // what it knows of viewpoints is kept
  double whole = 0, environment = 0;
  ProductClock::spent() = {};
  for (auto _ : state) {
    const auto begin = Clock::now();
    environment += training.update();
    const double time = seconds(Clock::now() - begin);
    state.SetIterationTime(time);
    whole += time;
  }
  state.counters["products"] = seconds(ProductClock::spent()) / whole;
  state.counters["environment"] = environment / whole;
}

// --- on a card ---

// The shapes of an iteration's products on the device.
class ProductShapes {
 public:
  struct Factors {
    at::Tensor a, b;
  };

  static void install() {
    at::addGlobalCallback(
        at::RecordFunctionCallback(&note).needsInputs(true).scopes({at::RecordScope::FUNCTION}));
  }
  // What is multiplied while this is not null.
  static std::vector<Factors>*& log() {
    static std::vector<Factors>* log = nullptr;
    return log;
  }

 private:
  static std::unique_ptr<at::ObserverContext> note(const at::RecordFunction& function) {
    if (log() == nullptr) return nullptr;
    const std::string_view name = function.name();
    const bool adds = name == "aten::addmm" || name == "aten::baddbmm";
    if (!adds && name != "aten::mm" && name != "aten::bmm") return nullptr;
    const auto inputs = function.inputs();
    const std::size_t first = adds ? 1 : 0;
    const at::Tensor a = inputs[first].toTensor(), b = inputs[first + 1].toTensor();
    // Autocast calls again with what it has converted.
    if (a.scalar_type() == b.scalar_type()) log()->push_back({a, b});
    return nullptr;
  }
};

void wait_for(c10::Device device) {
  (void)at::zeros({1}, at::TensorOptions(at::kFloat).device(device)).item<float>();
}

// Milliseconds of these products, each with its operands as they lay, on numbers that were there.
double products_alone(const std::vector<ProductShapes::Factors>& products, c10::Device device) {
  const at::NoGradGuard no_gradients;
  double least = std::numeric_limits<double>::infinity();
  constexpr int kRepetitions = 5;
  for (int i = 0; i < kRepetitions; ++i) {
    wait_for(device);
    const auto begin = Clock::now();
    for (const auto& [a, b] : products) (void)at::matmul(a, b);
    wait_for(device);
    least = std::min(least, 1e3 * seconds(Clock::now() - begin));
  }
  return least;
}

double operations_of(const std::vector<ProductShapes::Factors>& products) {
  double sum = 0;
  for (const auto& [a, b] : products) {
    sum += 2.0 * static_cast<double>(a.numel()) * static_cast<double>(b.size(-1));
  }
  return sum;
}

struct OnCard {
  const char* sizes;
  std::int64_t image;
  std::size_t episodes;
  neural::Precision precision;
};

void training_on_card(benchmark::State& state, const OnCard& what) {
  const c10::Device device = neural::core::open_agents_device("cuda");
  Training training(what.sizes, what.image, what.episodes, device);
  const auto iterate = [&] {
    const neural::core::PrecisionGuard guard(what.precision);
    return training.update();
  };
  constexpr int kWarmUp = 3;  // features go to the card, kernels are loaded
  for (int i = 0; i < kWarmUp; ++i) iterate();
  double whole = 0, environment = 0;
  for (auto _ : state) {
    const auto begin = Clock::now();
    environment += iterate();
    wait_for(device);
    const double time = seconds(Clock::now() - begin);
    state.SetIterationTime(time);
    whole += time;
  }
  std::vector<ProductShapes::Factors> products;
  ProductShapes::log() = &products;
  iterate();
  ProductShapes::log() = nullptr;
  const double alone = products_alone(products, device);
  state.counters["products"] = static_cast<double>(products.size());
  state.counters["products_ms"] = alone;
  state.counters["products_share"] = 1e-3 * alone * static_cast<double>(state.iterations()) / whole;
  state.counters["TFLOP"] = 1e-12 * operations_of(products);
  state.counters["environment"] = environment / whole;
}

void register_card() {
  try {
    neural::core::open_agents_device("cuda");
  } catch (const Error&) {
    return;  // no card
  }
  ProductShapes::install();
  using enum neural::Precision;
  for (const auto precision : {kFloat32, kTf32, kBfloat16}) {
    for (const OnCard& what :
         {OnCard{"duet-s", kImage, kTrained, precision},
          OnCard{"duet-s", kImage, kBatch, precision}, OnCard{"duet", 768, 8, precision},
          OnCard{"duet", 768, kBatch, precision}}) {
      benchmark::RegisterBenchmark(
          fmt::format("card/{}/{}_episodes/{}", what.sizes, what.episodes, enum_name(precision))
              .c_str(),
          [=](benchmark::State& state) { training_on_card(state, what); })
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
}

void register_all() {
  ProductClock::install();
  register_card();
  for (const int threads : {0, 1}) {
    benchmark::RegisterBenchmark(threads == 0 ? "train/all_cores" : "train/one_thread",
                                 [=](benchmark::State& state) { training(state, threads); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  }
  for (const PretrainingTask task :
       {PretrainingTask::kWords, PretrainingTask::kViews, PretrainingTask::kAction}) {
    for (const int threads : {0, 1}) {
      benchmark::RegisterBenchmark(
          fmt::format("pretrain/{}/{}", enum_name(task), threads == 0 ? "all_cores" : "one_thread")
              .c_str(),
          [=](benchmark::State& state) { iteration(state, task, threads); })
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace
}  // namespace enfilade

int main(int argc, char** argv) { return enfilade::bench::run(argc, argv, enfilade::register_all); }
