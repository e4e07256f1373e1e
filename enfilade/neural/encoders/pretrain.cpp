#include "enfilade/neural/pretrain.h"

#include <ATen/ATen.h>
#include <c10/core/InferenceMode.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/encoders/home_network.h"
#include "enfilade/neural/encoders/home_pictures.h"
#include "enfilade/neural/encoders/home_score.h"
#include "enfilade/neural/encoders/home_training.h"

namespace enfilade::neural {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kBatch = 32;
constexpr std::size_t kHeldOut = 10;       // every tenth viewpoint of a training scan
constexpr std::size_t kMostViews = 36;     // per viewpoint: more would look alike
constexpr std::size_t kTrialViews = 12;    // per viewpoint that the network is evaluated on
constexpr std::size_t kMostTrials = 200;   // such viewpoints: enough for precise scores
constexpr std::uint64_t kOrderStream = 1;  // of random numbers

struct Split {
  std::vector<encoders::LabelledPlace> training, seen, unseen;
};

Split split_places(const scan::PanoramaSet& panoramas, const PretrainConfig& config) {
  Split split;
  for (const std::string& scan : config.training) {
    const std::vector<encoders::LabelledPlace> places =
        encoders::places_of(panoramas, scan, config.room);
    for (std::size_t i = 0; i < places.size(); ++i) {
      (i % kHeldOut == kHeldOut / 2 ? split.seen : split.training).push_back(places[i]);
    }
  }
  for (const std::string& scan : config.unseen) {
    const std::vector<encoders::LabelledPlace> places =
        encoders::places_of(panoramas, scan, config.room);
    split.unseen.insert(split.unseen.end(), places.begin(), places.end());
  }
  if (split.training.empty()) {
    throw ArgumentError("training: no scan with pictures; at least one is expected");
  }
  encoders::thin_out(split.training, config.pictures);
  encoders::thin_out(split.seen, kMostTrials);
  encoders::thin_out(split.unseen, kMostTrials);
  return split;
}

// A short linear warm-up, then half a cosine down to 0.
double learning_rate(std::size_t step, std::size_t steps) {
  constexpr double kPeak = 2e-3, kClimb = 0.08;
  const double t = static_cast<double>(step) / static_cast<double>(steps);
  if (t < kClimb) return kPeak * (t + 1 / static_cast<double>(steps)) / kClimb;
  return kPeak * (0.5 + 0.5 * std::cos(std::numbers::pi * (t - kClimb) / (1 - kClimb)));
}

void train(encoders::HomeTraining& network, const encoders::LabelledPictures& pictures,
           const PretrainConfig& config, PretrainReport& report, const PretrainProgress& progress) {
  std::vector<std::int64_t> order(static_cast<std::size_t>(pictures.rooms.numel()));
  std::iota(order.begin(), order.end(), 0);
  Rng rng(config.seed, kOrderStream);
  const std::size_t batch = std::min(kBatch, order.size());
  const std::size_t each = order.size() / batch;  // the remainder is left out of this pass
  report.steps = each * config.epochs;
  std::vector<double> losses;
  for (std::size_t step = 0; step < report.steps; ++step) {
    if (step % each == 0) rng.shuffle(std::span(order));
    const auto begin = order.begin() + static_cast<std::ptrdiff_t>(step % each * batch);
    losses.push_back(network.step(pictures, {begin, begin + static_cast<std::ptrdiff_t>(batch)},
                                  learning_rate(step, report.steps)));
    if (progress) progress(step + 1, report.steps, losses.back());
  }
  const std::size_t last = std::max<std::size_t>(1, losses.size() / 10);
  report.loss =
      std::accumulate(losses.end() - static_cast<std::ptrdiff_t>(last), losses.end(), 0.0) /
      static_cast<double>(last);
}

// Means and deviations that normalise the features of training pictures.
void add_scales(const encoders::LabelledPictures& pictures, c10::Device device,
                core::Weights& weights) {
  constexpr std::int64_t kEnough = 2048, kAtOnce = 64;  // pictures
  // Features that hardly vary are not scaled up to a deviation of 1.
  constexpr double kLeastDeviation = 0.02;
  const c10::InferenceMode no_gradients;
  const encoders::HomeNetwork network(weights, device);
  const std::int64_t n = pictures.rooms.numel();
  const std::int64_t stride = std::max<std::int64_t>(1, n / kEnough);
  const at::Tensor some = pictures.colours.slice(0, 0, n, stride);
  std::vector<at::Tensor> features;
  for (const at::Tensor& part : some.split(kAtOnce)) {
    features.push_back(encoders::describe(network.run(encoders::as_input(part))).cpu());
  }
  const at::Tensor all = at::cat(features);
  weights["features.mean"] = all.mean(0).contiguous();
  weights["features.deviation"] = all.std(0, false).clamp_min(kLeastDeviation).contiguous();
}

void check(const PretrainConfig& config) {
  if (config.training.empty()) throw ArgumentError("training: no scan; at least one is expected");
  if (config.pictures == 0) throw ArgumentError("pictures: 0; at least 1 is expected");
  if (config.epochs == 0) throw ArgumentError("epochs: 0; at least 1 is expected");
}

double since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

}  // namespace

PretrainReport pretrain_home_encoder(const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                                     const PretrainConfig& config,
                                     const std::filesystem::path& file,
                                     const PretrainProgress& progress) {
  check(config);
  const c10::Device device = core::open_device(config.device);
  const Split split = split_places(*panoramas, config);
  PretrainReport report;
  Clock::time_point start = Clock::now();
  const auto draw = [&](const std::vector<encoders::LabelledPlace>& places, std::size_t views) {
    return encoders::draw_labelled(panoramas, places, views, config.seed, config.threads);
  };
  const std::size_t views = std::clamp<std::size_t>(
      (config.pictures + split.training.size() / 2) / split.training.size(), 1, kMostViews);
  encoders::LabelledPictures pictures = draw(split.training, views);
  encoders::LabelledPictures seen = draw(split.seen, kTrialViews);
  encoders::LabelledPictures unseen = draw(split.unseen, kTrialViews);
  report.drawing_seconds = since(start);

  const encoders::HomeWords words = encoders::words_of(pictures);
  for (encoders::LabelledPictures* set : {&pictures, &seen, &unseen})
    encoders::number_labels(words, *set);
  report.classes = words.classes;
  report.rooms = words.rooms;
  report.pictures = static_cast<std::size_t>(pictures.rooms.numel());

  start = Clock::now();
  encoders::HomeTraining network(words, pictures, config.seed, device);
  report.parameters = network.parameters();
  train(network, pictures, config, report, progress);
  core::Weights weights = network.folded();
  add_scales(pictures, device, weights);
  report.training_seconds = since(start);

  const encoders::HomeNetwork trained(weights, device);
  report.seen = encoders::score(trained, seen);
  report.unseen = encoders::score(trained, unseen);
  encoders::write_home_network(file, weights, words);
  return report;
}

}  // namespace enfilade::neural
