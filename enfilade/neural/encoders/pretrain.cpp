#include <ATen/ATen.h>
#include <c10/core/InferenceMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/encoders/home_network.h"
#include "enfilade/neural/encoders/home_pictures.h"
#include "enfilade/neural/pretrain.h"
#include "enfilade/render/renderer.h"

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
        encoders::places_of(panoramas, {&scan, 1}, config.room);
    for (std::size_t i = 0; i < places.size(); ++i) {
      (i % kHeldOut == kHeldOut / 2 ? split.seen : split.training).push_back(places[i]);
    }
  }
  split.unseen = encoders::places_of(panoramas, config.unseen, config.room);
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

using encoders::LabelledPlace;
using PlaceList = std::vector<LabelledPlace>;

constexpr double kPresent = 0.02;     // share of the pixels from which a class is shown
constexpr std::int64_t kFewest = 20;  // occurrences below which a precision is not meaningful
constexpr std::size_t kFolds = 5;     // one in this many training scans chooses the penalties
constexpr std::int64_t kViewsAround = render::kDiscreteViews;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Rows are views, 36 a viewpoint.
struct Samples {
  at::Tensor features;   // (n, dimensions) double
  at::Tensor shown;      // (n, kObjectClasses) whether the view shows a class
  at::Tensor thirds;     // (n, kObjectClasses, 3) likewise, of each third
  at::Tensor distances;  // (n, 3) mean ln metres; NaN: unknown
  at::Tensor rooms;      // (n) letters
};

PlaceList gather_places(const scan::PanoramaSet& panoramas, const std::vector<std::string>& scans,
                        const ProbeConfig& config, const char* what) {
  PlaceList places = encoders::places_of(panoramas, scans, config.room);
  if (places.empty()) {
    throw ArgumentError(fmt::format("{}: no scan with pictures; at least one is expected", what));
  }
  encoders::thin_out(places, config.viewpoints);
  return places;
}

at::Tensor features_of(const features::FeatureSet& features, const scan::PanoramaSet& panoramas,
                       const PlaceList& places) {
  const auto dimensions = static_cast<std::int64_t>(features.info().dimensions);
  at::Tensor all = at::empty({std::ssize(places), kViewsAround, dimensions}, at::kFloat);
  const auto size = static_cast<std::size_t>(kViewsAround * dimensions);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const scan::PanoramaSource& source = panoramas.source(places[i].scan);
    const std::string& viewpoint = source.poses()[places[i].viewpoint.at()].viewpoint;
    const auto row = features.row(source.scan(), viewpoint);
    if (!row) {
      throw LookupError(
          fmt::format("no features of viewpoint {} of scan {}; the file needs those "
                      "of all viewpoints with pictures",
                      viewpoint, source.scan()));
    }
    features.copy_views(*row, {all.data_ptr<float>() + i * size, size});
  }
  return all.flatten(0, 1).to(at::kDouble);
}

// (n, 1, rows, columns) -> (n, 3): of each third, over the cells where it is known; else NaN.
at::Tensor mean_distances(const at::Tensor& cells) {
  const at::Tensor known = at::isfinite(cells).to(at::kFloat);
  return (encoders::pool_thirds(cells.nan_to_num(0)) / encoders::pool_thirds(known)).squeeze(1);
}

// Labels of a few places at a time, as those of all cells take much memory.
Samples sample(const features::FeatureSet& features,
               const std::shared_ptr<const scan::PanoramaSet>& panoramas, const PlaceList& places,
               int threads) {
  constexpr std::size_t kAtOnce = 32;
  constexpr double kPixels = encoders::kHomeStride * encoders::kHomeStride;
  std::vector<at::Tensor> shown, thirds, distances, rooms;
  for (std::size_t i = 0; i < places.size(); i += kAtOnce) {
    const auto part = std::span(places).subspan(i, std::min(kAtOnce, places.size() - i));
    const auto labels = encoders::label_views(
        panoramas, part, features.info().camera.vertical_field_of_view, threads);
    const at::Tensor shares = labels.classes.to(at::kFloat) / kPixels;
    shown.push_back(shares.mean({2, 3}).gt(kPresent));
    thirds.push_back(encoders::pool_thirds(shares).gt(kPresent));
    distances.push_back(mean_distances(labels.distances));
    rooms.push_back(labels.rooms);
  }
  return {features_of(features, *panoramas, places), at::cat(shown), at::cat(thirds),
          at::cat(distances), at::cat(rooms)};
}

// Classes but void and unlabeled that occur often enough on both sides.
at::Tensor common(const at::Tensor& training, const at::Tensor& unseen) {
  const auto often = [](const at::Tensor& shown) { return shown.sum(0).ge(kFewest); };
  at::Tensor both = often(training) & often(unseen);
  both[0] = false;
  both[encoders::kObjectClasses - 1] = false;
  return both.nonzero().squeeze(1);
}

std::vector<std::int64_t> letters_of(const at::Tensor& rooms) {
  const auto* letters = rooms.data_ptr<std::int64_t>();
  std::set<std::int64_t> found(letters, letters + rooms.numel());
  found.erase('-');
  return {found.begin(), found.end()};
}

// Kinds of labels, each with a penalty of its own.
enum Kind : std::size_t { kShown, kThirds, kRooms, kDistances, kKinds };
using Targets = std::array<at::Tensor, kKinds>;  // (n, columns) double

// What the regressions are to give. A distance that is unknown counts as the mean.
Targets targets_of(const Samples& s, const at::Tensor& classes,
                   const std::vector<std::int64_t>& letters) {
  const at::Tensor known = at::isfinite(s.distances);
  const at::Tensor mean = s.distances.nan_to_num(0).sum(0) / known.sum(0).clamp_min(1);
  return {s.shown.index_select(1, classes).to(at::kDouble),
          s.thirds.index_select(1, classes).flatten(1).to(at::kDouble),
          s.rooms.unsqueeze(1).eq(at::tensor(letters, at::kLong)).to(at::kDouble),
          at::where(known, s.distances, mean).to(at::kDouble)};
}

// Sums over views that a least-squares fit needs. Features are scaled and end with a 1.
struct LeastSquares {
  at::Tensor squares, products;  // (d, d), (d, columns)
  double views = 0;

  static LeastSquares of(const at::Tensor& features, const at::Tensor& targets) {
    return {features.t().matmul(features), features.t().matmul(targets),
            static_cast<double>(features.size(0))};
  }
  // (d, columns): least squares plus penalty * views * |weights|^2.
  at::Tensor solve(double penalty) const {
    at::Tensor ridge = at::full({squares.size(0)}, penalty * views, at::kDouble);
    ridge[-1] = 1e-9 * views;  // the constant is free
    const at::Tensor root = at::linalg_cholesky(squares + ridge.diag());
    return at::cholesky_solve(products, root);
  }
};

// Regressions of all kinds of labels.
class Probe {
 public:
  // \param held (n) flags the views that choose the penalties
  Probe(const at::Tensor& features, const Targets& targets, const at::Tensor& held)
      : mean_(features.mean(0)), deviation_(features.std(0, false).clamp_min(1e-6)) {
    for (std::size_t k = 0; k < kKinds; ++k) widths_.at(k) = targets.at(k).size(1);
    const at::Tensor x = scaled(features), y = at::cat(targets, 1);
    const at::Tensor fit = held.logical_not().nonzero().squeeze(1);
    const at::Tensor choose = held.nonzero().squeeze(1);
    const at::Tensor x_choose = x.index_select(0, choose), y_choose = y.index_select(0, choose);
    const LeastSquares fitted = LeastSquares::of(x.index_select(0, fit), y.index_select(0, fit));
    const std::array<double, kKinds> best = penalties(fitted, x_choose, y_choose);
    const LeastSquares rest = LeastSquares::of(x_choose, y_choose);
    const LeastSquares all{fitted.squares + rest.squares, fitted.products + rest.products,
                           fitted.views + rest.views};
    for (std::size_t k = 0; k < kKinds; ++k) weights_.at(k) = split(all.solve(best.at(k))).at(k);
  }

  Targets apply(const at::Tensor& features) const {
    const at::Tensor x = scaled(features);
    Targets said;
    for (std::size_t k = 0; k < kKinds; ++k) said.at(k) = x.matmul(weights_.at(k));
    return said;
  }

 private:
  at::Tensor scaled(const at::Tensor& features) const {
    return at::cat(
        {(features - mean_) / deviation_, at::ones({features.size(0), 1}, features.options())}, 1);
  }

  std::vector<at::Tensor> split(const at::Tensor& columns) const {
    return columns.split_with_sizes(widths_, 1);
  }

  // Of each kind the penalty whose fit does best on other views.
  std::array<double, kKinds> penalties(const LeastSquares& fitted, const at::Tensor& x,
                                       const at::Tensor& y) const {
    constexpr std::array<double, 5> kPenalties{1e-4, 1e-3, 1e-2, 1e-1, 1};
    std::array<double, kKinds> best{}, least{};
    least.fill(std::numeric_limits<double>::infinity());
    for (const double penalty : kPenalties) {
      const std::vector<at::Tensor> errors = split((x.matmul(fitted.solve(penalty)) - y).square());
      for (std::size_t k = 0; k < kKinds; ++k) {
        const double error = errors[k].sum().item<double>();
        if (error >= least.at(k)) continue;
        best.at(k) = penalty;
        least.at(k) = error;
      }
    }
    return best;
  }

  at::Tensor mean_, deviation_;
  std::array<std::int64_t, kKinds> widths_{};
  std::array<at::Tensor, kKinds> weights_;
};

// Every fifth scan chooses the penalties; where there are too few scans, every fifth viewpoint.
at::Tensor held_out(const PlaceList& places) {
  std::vector<std::uint8_t> flags;
  std::set<std::size_t> scans;
  for (const LabelledPlace& place : places) scans.insert(place.scan.at());
  std::size_t place_number = 0;
  for (const LabelledPlace& place : places) {
    const auto scan = std::distance(scans.begin(), scans.find(place.scan.at()));
    const std::size_t number =
        scans.size() >= kFolds ? static_cast<std::size_t>(scan) : place_number;
    flags.insert(flags.end(), kViewsAround, number % kFolds == kFolds - 1 ? 1 : 0);
    ++place_number;
  }
  return at::tensor(flags, at::kByte).to(at::kBool);
}

struct ClassPrecision {
  double mean = kNaN, chance = kNaN;
};

// Over columns of the same class. \param said, truths (n, classes, places in the picture)
ClassPrecision precision_of(const at::Tensor& said, const at::Tensor& truths) {
  const std::int64_t classes = truths.size(1);
  if (classes == 0) return {};
  ClassPrecision sum{0, 0};
  for (std::int64_t k = 0; k < classes; ++k) {
    const at::Tensor scores = said.select(1, k).flatten().to(at::kFloat).contiguous();
    const at::Tensor shown = truths.select(1, k).flatten().to(at::kByte).contiguous();
    const auto n = static_cast<std::size_t>(shown.numel());
    sum.mean += encoders::average_precision({scores.data_ptr<float>(), n},
                                            {shown.data_ptr<std::uint8_t>(), n});
    sum.chance += shown.to(at::kDouble).mean().item<double>();
  }
  return {sum.mean / static_cast<double>(classes), sum.chance / static_cast<double>(classes)};
}

// Share of rows with the right room among those whose room is known.
double right_rooms(const at::Tensor& said, const at::Tensor& rooms,
                   const std::vector<std::int64_t>& letters) {
  const at::Tensor known = rooms.ne('-');
  const double n = known.sum().item<double>();
  if (n == 0) return kNaN;
  const at::Tensor named = at::tensor(letters, at::kLong).index_select(0, said.argmax(1));
  return (named.eq(rooms) & known).sum().item<double>() / n;
}

void score_rooms(const at::Tensor& said, const Samples& training, const Samples& unseen,
                 const std::vector<std::int64_t>& letters, ProbeReport& report) {
  report.room = report.viewpoint_room = report.room_chance = kNaN;
  if (letters.empty()) return;
  report.room = right_rooms(said, unseen.rooms, letters);
  const at::Tensor sums = said.view({-1, kViewsAround, said.size(1)}).sum(1);
  report.viewpoint_room = right_rooms(sums, unseen.rooms.slice(0, 0, {}, kViewsAround), letters);
  const at::Tensor counts =
      training.rooms.unsqueeze(1).eq(at::tensor(letters, at::kLong)).sum(0, true);
  report.room_chance =
      right_rooms(counts.expand({unseen.rooms.numel(), -1}), unseen.rooms, letters);
}

// Mean absolute error where the distance is known.
double error_of(const at::Tensor& said, const at::Tensor& distances) {
  const at::Tensor known = at::isfinite(distances);
  const double n = known.sum().item<double>();
  if (n == 0) return kNaN;
  return ((said - distances.nan_to_num(0)).abs() * known).sum().item<double>() / n;
}

void check(const features::FeatureSet& features, const ProbeConfig& config) {
  if (config.viewpoints == 0) throw ArgumentError("viewpoints: 0; at least 1 is expected");
  if (features.info().views != render::kDiscreteViews) {
    throw ArgumentError(fmt::format("features: {} views a viewpoint; {} are expected",
                                    features.info().views, render::kDiscreteViews));
  }
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

ProbeReport probe_features(const features::FeatureSet& features,
                           const std::shared_ptr<const scan::PanoramaSet>& panoramas,
                           const ProbeConfig& config) {
  check(features, config);
  const c10::InferenceMode no_gradients;
  const PlaceList places = gather_places(*panoramas, config.training, config, "training");
  const PlaceList others = gather_places(*panoramas, config.unseen, config, "unseen");
  const Samples training = sample(features, panoramas, places, config.threads);
  const Samples unseen = sample(features, panoramas, others, config.threads);

  const at::Tensor classes = common(training.shown, unseen.shown);
  const std::vector<std::int64_t> letters = letters_of(training.rooms);
  const Targets targets = targets_of(training, classes, letters);
  const Targets said = Probe(training.features, targets, held_out(places)).apply(unseen.features);

  ProbeReport report{.dimensions = features.info().dimensions,
                     .training = places.size(),
                     .unseen = others.size(),
                     .classes = static_cast<std::size_t>(classes.numel())};
  const ClassPrecision view =
      precision_of(said[kShown].unsqueeze(2), unseen.shown.index_select(1, classes).unsqueeze(2));
  const at::Tensor thirds = unseen.thirds.index_select(1, classes);
  const ClassPrecision third = precision_of(said[kThirds].view_as(thirds), thirds);
  report.view_precision = view.mean;
  report.view_chance = view.chance;
  report.third_precision = third.mean;
  report.third_chance = third.chance;
  score_rooms(said[kRooms], training, unseen, letters, report);
  report.distance_error = error_of(said[kDistances], unseen.distances);
  report.distance_chance = error_of(targets[kDistances].mean(0), unseen.distances);
  return report;
}

}  // namespace enfilade::neural
