#include "enfilade/neural/encoders/home_score.h"

#include <ATen/ATen.h>
#include <c10/core/InferenceMode.h>
#include <algorithm>
#include <limits>
#include <numeric>

#include "enfilade/neural/encoders/home_training.h"

namespace enfilade::neural::encoders {
namespace {

constexpr double kPresent = 0.02;     // share of a third from which a class counts as present
constexpr std::int64_t kFewest = 20;  // occurrences below which a precision is not meaningful
constexpr std::int64_t kAtOnce = 64;  // pictures

// The network's outputs for all pictures, in the processor's memory.
HomeOutputs run_all(const HomeNetwork& network, const at::Tensor& colours) {
  std::vector<at::Tensor> classes, distances, rooms;
  for (std::int64_t i = 0; i < colours.size(0); i += kAtOnce) {
    const std::int64_t end = std::min(colours.size(0), i + kAtOnce);
    const HomeOutputs out = network.run(as_input(colours.slice(0, i, end)));
    classes.push_back(pool_thirds(out.classes.softmax(1)).cpu());
    distances.push_back(out.distances.cpu());
    rooms.push_back(out.rooms.cpu());
  }
  return {at::cat(classes), at::cat(distances), at::cat(rooms)};
}

// (n, k, 3) -> all thirds of one class.
at::Tensor of_class(const at::Tensor& thirds, std::int64_t k) {
  return thirds.select(1, k).flatten().contiguous();
}

void add_precisions(const at::Tensor& said, const at::Tensor& shown, HomeScore& score) {
  std::size_t counted = 0;
  for (std::int64_t k = 0; k < shown.size(1); ++k) {
    const at::Tensor scores = of_class(said, k), truths = of_class(shown, k);
    const auto n = static_cast<std::size_t>(truths.numel());
    const std::int64_t times = truths.sum().item<std::int64_t>();
    double precision = std::numeric_limits<double>::quiet_NaN();
    if (times >= kFewest) {
      precision =
          average_precision({scores.data_ptr<float>(), n}, {truths.data_ptr<std::uint8_t>(), n});
      score.mean_average_precision += precision;
      score.chance += static_cast<double>(times) / static_cast<double>(n);
      ++counted;
    }
    score.average_precision.push_back(precision);
  }
  if (counted == 0) return;
  score.mean_average_precision /= static_cast<double>(counted);
  score.chance /= static_cast<double>(counted);
}

}  // namespace

double average_precision(std::span<const float> scores, std::span<const std::uint8_t> truths) {
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](auto a, auto b) { return scores[a] > scores[b]; });
  double hits = 0, sum = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (truths[order[i]] == 0) continue;
    hits += 1;
    sum += hits / static_cast<double>(i + 1);
  }
  return hits > 0 ? sum / hits : std::numeric_limits<double>::quiet_NaN();
}

HomeScore score(const HomeNetwork& network, const LabelledPictures& pictures) {
  HomeScore score;
  score.pictures = static_cast<std::size_t>(pictures.rooms.numel());
  if (score.pictures == 0) return score;
  const c10::InferenceMode no_gradients;
  const HomeOutputs said = run_all(network, pictures.colours);
  constexpr double kPixels = kHomeStride * kHomeStride;
  const at::Tensor shares = pool_thirds(pictures.classes.to(at::kFloat) / kPixels);
  add_precisions(said.classes, shares.gt(kPresent).to(at::kByte), score);
  const at::Tensor named = pictures.rooms.ge(0);
  const double rooms = named.sum().item<double>();
  if (rooms > 0) {
    score.rooms = (said.rooms.argmax(1).eq(pictures.rooms) & named).sum().item<double>() / rooms;
  }
  const at::Tensor known = at::isfinite(pictures.distances);
  const at::Tensor miss = (said.distances - pictures.distances.nan_to_num(0)).abs() * known;
  score.distance_error = miss.sum().item<double>() / std::max(1.0, known.sum().item<double>());
  return score;
}

}  // namespace enfilade::neural::encoders
