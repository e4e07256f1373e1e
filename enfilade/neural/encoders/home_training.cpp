#include "enfilade/neural/encoders/home_training.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "enfilade/neural/core/random_weights.h"

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

}  // namespace enfilade::neural::encoders
