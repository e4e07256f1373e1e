#include "enfilade/neural/encoders/home_network.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <c10/core/InferenceMode.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/encoders/encoder_input.h"

namespace enfilade::neural::encoders {
namespace {

constexpr double kWhite = 255;

// Mirrors the flagged pictures: reverses their columns.
void mirror(const at::Tensor& flags, at::Tensor& values) {
  values = at::where(flags.view({-1, 1, 1, 1}), values.flip(3), values);
}

LabelledPictures select(const LabelledPictures& from, const std::vector<std::int64_t>& which,
                        c10::Device device) {
  const at::Tensor rows = at::tensor(which, at::kLong);
  const auto take = [&](const at::Tensor& values) {
    return values.index_select(0, rows).to(device);
  };
  return {take(from.colours), take(from.classes), take(from.distances), take(from.rooms)};
}

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

constexpr const char *kFormatKey = "format", *kFormat = "enfilade-home-encoder-1";
constexpr const char *kClassesKey = "classes", *kRoomsKey = "rooms";

Convolution prepared(const core::Weights& weights, const std::string& name, const HomeLayer& layer,
                     c10::Device device) {
  Convolution c;
  c.weight = weights.at(name + ".weight");
  c.bias = weights.at(name + ".bias");
  c.stride = layer.stride;
  c.dilation = layer.dilation;
  c.padding = layer.size / 2 * layer.dilation;
  prepare(c, device, ActivationLayout::kChannelsLast);
  return c;
}

std::string trunk_name(std::size_t i) { return fmt::format("trunk.{}", i); }

[[noreturn]] void fault(const std::filesystem::path& file, const char* where, std::string message) {
  refuse(file.string(), where, "no-home-encoder", std::move(message));
}

std::vector<std::int64_t> parse_classes(const std::filesystem::path& file, std::string_view text) {
  std::vector<std::int64_t> classes;
  for (const char* next = text.data(); next != text.data() + text.size();) {
    std::int64_t number = 0;
    const auto [stop, code] = std::from_chars(next, text.data() + text.size(), number);
    if (code != std::errc()) fault(file, kClassesKey, "whole numbers are expected");
    classes.push_back(number);
    next = stop + (stop != text.data() + text.size() && *stop == ' ' ? 1 : 0);
  }
  return classes;
}

// An untrained network with about as many classes and rooms as model homes have.
HomeFile random_network(std::uint64_t seed) {
  HomeFile home;
  home.words.rooms = "abcdefghij";
  for (std::int64_t i = 0; i < 36; ++i) home.words.classes.push_back(i);
  Rng rng(seed);
  for (const core::ArraySpec& array : home_arrays(home.words)) {
    home.weights[array.name] = array.shape.size() > 1 ? core::he_normal(array.shape, rng)
                               : array.name == "features.deviation" ? at::ones(array.shape)
                                                                    : at::zeros(array.shape);
  }
  return home;
}

class HomeEncoder final : public CheckedEncoder {
 public:
  HomeEncoder(const HomeFile& file, c10::Device device)
      : CheckedEncoder(device),
        network_(file.weights, device),
        mean_(file.weights.at("features.mean").to(device)),
        deviation_(file.weights.at("features.deviation").to(device)) {
    hash_ = core::hash_of(file.weights);
  }

  std::size_t dimensions() const override { return static_cast<std::size_t>(mean_.numel()); }
  Camera camera() const override { return {kHomeWidth, kHomeHeight, degrees(60)}; }
  std::string preprocessing() const override { return "home"; }
  render::Normalisation normalisation() const override {
    return {{kHomeMean, kHomeMean, kHomeMean}, {kHomeDeviation, kHomeDeviation, kHomeDeviation}};
  }

  void encode(std::span<const float> pictures, std::size_t n, const Camera& camera,
              std::span<float> features) override {
    if (camera.width != kHomeWidth || camera.height != kHomeHeight) {
      throw ArgumentError(fmt::format("camera: {} x {} pixels; this encoder looks at {} x {}",
                                      camera.width, camera.height, kHomeWidth, kHomeHeight));
    }
    CheckedEncoder::encode(pictures, n, camera, features);
  }

 private:
  at::Tensor run(std::span<const float> pictures, std::size_t n, const Camera& camera) override {
    return (describe(network_.run(tensor(pictures, n, camera))) - mean_) / deviation_;
  }

  HomeNetwork network_;
  at::Tensor mean_, deviation_;
};

}  // namespace

HomeWords words_of(const LabelledPictures& pictures) {
  // Share of all pixels. Rarer classes cannot be learnt from so few pictures.
  constexpr double kLeastShare = 2e-4;
  const at::Tensor counts = pictures.classes.sum({0, 2, 3}, false, at::kLong);
  const double total = counts.sum().item<double>();
  HomeWords words{{0}, {}};
  for (std::int64_t c = 1; c + 1 < kObjectClasses; ++c) {
    if (counts[c].item<double>() >= kLeastShare * total) words.classes.push_back(c);
  }
  const auto* rooms = pictures.rooms.data_ptr<std::int64_t>();
  std::set<char> letters;
  for (std::int64_t i = 0; i < pictures.rooms.numel(); ++i) {
    letters.insert(static_cast<char>(rooms[i]));
  }
  letters.erase('-');
  if (letters.empty()) letters.insert('-');  // no room has a label: all are of this one kind
  words.rooms.assign(letters.begin(), letters.end());
  return words;
}

void number_labels(const HomeWords& words, LabelledPictures& pictures) {
  const std::int64_t n = pictures.classes.size(0), c = std::ssize(words.classes);
  std::vector<std::int64_t> number(kObjectClasses, 0);
  for (std::int64_t k = 0; k < c; ++k) {
    number[static_cast<std::size_t>(words.classes[static_cast<std::size_t>(k)])] = k;
  }
  pictures.classes = at::zeros({n, c, kHomeRows, kHomeColumns}, at::kByte)
                         .index_add(1, at::tensor(number, at::kLong), pictures.classes);
  auto* rooms = pictures.rooms.data_ptr<std::int64_t>();
  for (std::int64_t i = 0; i < n; ++i) {
    const std::size_t found = words.rooms.find(static_cast<char>(rooms[i]));
    rooms[i] = found == std::string::npos ? -1 : static_cast<std::int64_t>(found);
  }
}

at::Tensor as_input(const at::Tensor& colours) {
  return (colours.permute({0, 3, 1, 2}).to(at::kFloat) / kWhite - kHomeMean) / kHomeDeviation;
}

HomeTraining::HomeTraining(const HomeWords& words, const LabelledPictures& pictures,
                           std::uint64_t seed, c10::Device device)
    : device_(device), rng_(seed) {
  for (const HomeLayer& l : kHomeLayers) {
    TrunkLayer layer;
    // Channels last in memory, as in the input: a seventh faster than channels first.
    layer.weight = parameter(core::he_normal({l.out, l.in, l.size, l.size}, rng_)
                                 .contiguous(at::MemoryFormat::ChannelsLast));
    layer.scale = parameter(at::ones({l.out}));
    layer.shift = parameter(at::zeros({l.out}));
    layer.mean = at::zeros({l.out}).to(device);
    layer.variance = at::ones({l.out}).to(device);
    trunk_.push_back(std::move(layer));
  }
  classes_ = make_head({std::ssize(words.classes), kHomeChannels, 1, 1});
  distances_ = make_head({1, kHomeChannels, 1, 1});
  rooms_ = make_head({std::ssize(words.rooms), kHomeChannels});
  // Walls cover a third of all pixels, lamps a hundredth. A weight of 1 / sqrt(share) is between
  // equal weights of all pixels (1) and equal weights of all classes (1 / share).
  constexpr double kRarest = 1e-3;
  const at::Tensor counts = pictures.classes.sum({0, 2, 3}, false, at::kLong).to(at::kFloat);
  class_weights_ = (counts / counts.sum()).clamp_min(kRarest).rsqrt().view({-1, 1, 1}).to(device);
}

at::Tensor HomeTraining::parameter(at::Tensor values) {
  values = values.to(device_);
  moments_.push_back({at::zeros_like(values), at::zeros_like(values)});
  values.set_requires_grad(true);
  return parameters_.emplace_back(values);
}

HomeTraining::Head HomeTraining::make_head(const std::vector<std::int64_t>& shape) {
  constexpr double kSmall = 0.01;  // at first all answers are about equally likely
  return {parameter(core::normal(shape, kSmall, rng_)), parameter(at::zeros({shape[0]}))};
}

HomeOutputs HomeTraining::run(at::Tensor x) {
  constexpr double kMomentum = 0.1;
  for (std::size_t i = 0; i < trunk_.size(); ++i) {
    const HomeLayer& l = kHomeLayers.at(i);
    TrunkLayer& layer = trunk_[i];
    const std::int64_t padding = l.size / 2 * l.dilation;
    x = at::conv2d(x, layer.weight, {}, {l.stride, l.stride}, {padding, padding},
                   {l.dilation, l.dilation});
    x = at::relu(at::batch_norm(x, layer.scale, layer.shift, layer.mean, layer.variance, true,
                                kMomentum, kBatchNormEpsilon, true));
  }
  return {at::conv2d(x, classes_.weight, classes_.bias),
          at::conv2d(x, distances_.weight, distances_.bias),
          at::linear(x.mean({2, 3}), rooms_.weight, rooms_.bias)};
}

at::Tensor HomeTraining::loss_of(const HomeOutputs& outputs, const LabelledPictures& truth) const {
  const at::Tensor weights = truth.classes.to(at::kFloat) * class_weights_;
  const at::Tensor classes = -(outputs.classes.log_softmax(1) * weights).sum() / weights.sum();
  const at::Tensor known = at::isfinite(truth.distances);
  const at::Tensor miss = outputs.distances - truth.distances.nan_to_num(0);
  const at::Tensor distances = (miss.abs() * known).sum() / known.sum().to(at::kFloat).clamp_min(1);
  const at::Tensor likely = outputs.rooms.log_softmax(1);
  const at::Tensor named = truth.rooms.ge(0);
  const at::Tensor chosen = likely.gather(1, truth.rooms.clamp_min(0).unsqueeze(1)).squeeze(1);
  const at::Tensor rooms = -(chosen * named).sum() / named.sum().to(at::kFloat).clamp_min(1);
  // Few viewpoints have a room's label: a small weight avoids overfitting to them.
  constexpr double kDistances = 0.5, kRooms = 0.3;
  return classes + kDistances * distances + kRooms * rooms;
}

double HomeTraining::step(const LabelledPictures& pictures, const std::vector<std::int64_t>& which,
                          double learning_rate) {
  LabelledPictures batch = select(pictures, which, device_);
  const auto n = static_cast<std::int64_t>(which.size());
  std::vector<float> gains, shifts;
  std::vector<std::uint8_t> flags;
  constexpr double kGain = 0.2, kShift = 0.3;  // in the input's units: a quarter of white is 1
  for (std::int64_t i = 0; i < n; ++i) {
    flags.push_back(static_cast<std::uint8_t>(rng_.below(2)));
    shifts.push_back(static_cast<float>(kShift * (2 * rng_.uniform() - 1)));
    for (int c = 0; c < 3; ++c) {
      gains.push_back(static_cast<float>(1 + kGain * (2 * rng_.uniform() - 1)));
    }
  }
  const at::Tensor mirrored = at::tensor(flags, at::kByte).to(at::kBool).to(device_);
  at::Tensor input = as_input(batch.colours);
  input = input * at::tensor(gains).view({n, 3, 1, 1}).to(device_) +
          at::tensor(shifts).view({n, 1, 1, 1}).to(device_);
  mirror(mirrored, input);
  mirror(mirrored, batch.classes);
  mirror(mirrored, batch.distances);
  for (at::Tensor& p : parameters_) p.mutable_grad() = at::Tensor();
  const at::Tensor loss = loss_of(run(input.contiguous(at::MemoryFormat::ChannelsLast)), batch);
  loss.backward();
  adam(learning_rate);
  return loss.item<double>();
}

// Adam (Kingma and Ba 2015) with decoupled weight decay (Loshchilov and Hutter 2019).
void HomeTraining::adam(double learning_rate) {
  constexpr double kFirst = 0.9, kSecond = 0.999, kEpsilon = 1e-8, kDecay = 1e-2;
  const c10::NoGradGuard no_gradients;
  ++steps_;
  const double step = learning_rate / (1 - std::pow(kFirst, steps_));
  const double correction = std::sqrt(1 - std::pow(kSecond, steps_));
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    at::Tensor& p = parameters_[i];
    const at::Tensor& gradient = p.grad();
    Moments& m = moments_[i];
    m.first.mul_(kFirst).add_(gradient, 1 - kFirst);
    m.second.mul_(kSecond).addcmul_(gradient, gradient, 1 - kSecond);
    if (p.dim() > 1) p.mul_(1 - learning_rate * kDecay);
    p.addcdiv_(m.first, (m.second.sqrt() / correction).add_(kEpsilon), -step);
  }
}

core::Weights HomeTraining::folded() const {
  const c10::NoGradGuard no_gradients;
  core::Weights weights;
  const auto keep = [&weights](const std::string& name, const Head& values) {
    weights[name + ".weight"] = values.weight.detach().cpu().contiguous().clone();
    weights[name + ".bias"] = values.bias.detach().cpu().contiguous().clone();
  };
  for (std::size_t i = 0; i < trunk_.size(); ++i) {
    const TrunkLayer& layer = trunk_[i];
    Convolution c;
    c.weight = layer.weight;
    fold({layer.scale, layer.shift, layer.mean, layer.variance}, c);
    keep(fmt::format("trunk.{}", i), {c.weight, c.bias});
  }
  keep("classes", classes_);
  keep("distances", distances_);
  keep("rooms", rooms_);
  return weights;
}

std::size_t HomeTraining::parameters() const {
  std::size_t n = 0;
  for (const at::Tensor& p : parameters_) n += static_cast<std::size_t>(p.numel());
  return n;
}

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

at::Tensor pool_thirds(const at::Tensor& cells) {
  std::vector<at::Tensor> thirds;
  for (std::size_t i = 0; i < kThirds; ++i) {
    thirds.push_back(cells.slice(3, kThirdColumns.at(i), kThirdColumns.at(i + 1)).mean({2, 3}));
  }
  return at::stack(thirds, 2);
}

at::Tensor describe(const HomeOutputs& outputs) {
  const at::Tensor shares = pool_thirds(outputs.classes.softmax(1)).sqrt();
  const at::Tensor distances = pool_thirds(outputs.distances);
  return at::cat({shares.flatten(1), distances.flatten(1), outputs.rooms.softmax(1)}, 1);
}

std::vector<core::ArraySpec> home_arrays(const HomeWords& words) {
  const auto classes = std::ssize(words.classes), rooms = std::ssize(words.rooms);
  std::vector<core::ArraySpec> arrays;
  for (std::size_t i = 0; i < kHomeLayers.size(); ++i) {
    const HomeLayer& layer = kHomeLayers.at(i);
    core::add_layer(arrays, trunk_name(i), {layer.out, layer.in, layer.size, layer.size});
  }
  core::add_layer(arrays, "classes", {classes, kHomeChannels, 1, 1});
  core::add_layer(arrays, "distances", {1, kHomeChannels, 1, 1});
  core::add_layer(arrays, "rooms", {rooms, kHomeChannels});
  const std::int64_t dimensions = kThirds * (classes + 1) + rooms;
  arrays.push_back({"features.mean", {dimensions}});
  arrays.push_back({"features.deviation", {dimensions}});
  return arrays;
}

HomeNetwork::HomeNetwork(const core::Weights& weights, c10::Device device) : device_(device) {
  for (std::size_t i = 0; i < kHomeLayers.size(); ++i) {
    trunk_.push_back(prepared(weights, trunk_name(i), kHomeLayers.at(i), device));
  }
  constexpr HomeLayer kPointwise{kHomeChannels, 0, 1, 1, 1};
  classes_ = prepared(weights, "classes", kPointwise, device);
  distances_ = prepared(weights, "distances", kPointwise, device);
  rooms_weight_ = weights.at("rooms.weight").to(device);
  rooms_bias_ = weights.at("rooms.bias").to(device);
}

HomeOutputs HomeNetwork::run(const at::Tensor& pictures) const {
  at::Tensor x = prepare(pictures, device_, ActivationLayout::kChannelsLast);
  for (const Convolution& layer : trunk_) {
    x = apply(layer, x);
    at::relu_(x);
  }
  return {apply(classes_, x), apply(distances_, x),
          at::linear(x.mean({2, 3}), rooms_weight_, rooms_bias_)};
}

void write_home_network(const std::filesystem::path& file, const core::Weights& weights,
                        const HomeWords& words) {
  features::write_safetensors(file, core::as_arrays(weights),
                              {{kFormatKey, kFormat},
                               {kClassesKey, fmt::format("{}", fmt::join(words.classes, " "))},
                               {kRoomsKey, words.rooms}});
}

HomeFile read_home_network(const std::filesystem::path& file) {
  const features::TensorFile arrays = features::TensorFile::open(file);
  const auto& metadata = arrays.metadata();
  const auto value = [&](const char* key) {
    const auto found = metadata.find(key);
    if (found == metadata.end()) {
      fault(file, key, "no such metadata; a file of `enfilade pretrain` is expected");
    }
    return found->second;
  };
  if (value(kFormatKey) != kFormat) {
    fault(file, kFormatKey,
          fmt::format("{:?} is expected: run `enfilade pretrain` of this version", kFormat));
  }
  HomeFile home{{}, {parse_classes(file, value(kClassesKey)), value(kRoomsKey)}};
  if (home.words.classes.empty() || home.words.rooms.empty()) {
    fault(file, kClassesKey, "at least one class and one room are expected");
  }
  home.weights = core::read_weights(arrays, home_arrays(home.words));
  return home;
}

std::unique_ptr<ImageEncoder> make_home_encoder(const EncoderConfig& config) {
  const c10::Device device = core::open_device(config.device);
  return std::make_unique<HomeEncoder>(
      config.weights.empty() ? random_network(config.seed) : read_home_network(config.weights),
      device);
}

}  // namespace enfilade::neural::encoders
