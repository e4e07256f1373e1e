#include "enfilade/neural/core/optimizer.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "enfilade/core/errors.h"

namespace enfilade::neural::core {
namespace {

constexpr const char* kFirst = "optimizer.first.";
constexpr const char* kSecond = "optimizer.second.";
// Two halves, as float32 counts exactly only to 2^24.
constexpr const char* kUpdates = "optimizer.updates";
constexpr std::uint64_t kHalf = 1U << 20U;

at::Tensor count_tensor(std::uint64_t count) {
  return at::tensor({static_cast<float>(count / kHalf), static_cast<float>(count % kHalf)});
}

std::vector<at::Tensor> gradients_of(const Weights& weights, std::string_view part) {
  std::vector<at::Tensor> gradients;
  for (const auto& [name, weight] : weights) {
    if (name.starts_with(part) && weight.grad().defined()) gradients.push_back(weight.grad());
  }
  return gradients;
}

}  // namespace

void clear_gradients(const Weights& weights) {
  for (const auto& [name, weight] : weights) at::Tensor(weight).mutable_grad().reset();
}

double gradient_norm(const Weights& weights, std::string_view part) {
  const std::vector<at::Tensor> gradients = gradients_of(weights, part);
  return gradients.empty() ? 0 : at::stack(at::_foreach_norm(gradients)).norm().item<double>();
}

double follow_back(const at::Tensor& loss) {
  loss.backward();
  // Read afterwards, so that a card need not wait for us in between.
  const double value = loss.item<double>();
  if (!std::isfinite(value)) {
    throw Error(fmt::format("the loss is {}, not a finite number", value));
  }
  return value;
}

OptimizerConfig optimizer_of(const models::TrainConfig& config, std::vector<std::string> parts) {
  return {.kind = config.optimizer,
          .rates = config.adam,
          .clip = config.clip,
          .parts = std::move(parts),
          .warm_up = config.warm_up,
          .end = config.schedule == models::Schedule::kLinear ? config.iterations : 0};
}

double WeightOptimizer::rate() const noexcept {
  const auto next = static_cast<double>(updates_ + 1);
  double share = 1;
  if (updates_ < config_.warm_up) {
    share = next / static_cast<double>(config_.warm_up);
  } else if (config_.end > config_.warm_up) {
    const auto end = static_cast<double>(config_.end);
    share = std::max(
        0.0, (end - static_cast<double>(updates_)) / (end - static_cast<double>(config_.warm_up)));
  }
  return share * config_.rates.learning_rate;
}

void WeightOptimizer::clip(const Weights& weights) const {
  constexpr double kSmall = 1e-6;  // as in torch.nn.utils.clip_grad_norm_
  for (const std::string& part : config_.parts) {
    const double share = config_.clip / (gradient_norm(weights, part) + kSmall);
    if (share >= 1) continue;
    at::_foreach_mul_(gradients_of(weights, part), share);
  }
}

double WeightOptimizer::update(const Weights& weights) {
  const c10::NoGradGuard no_gradients;
  const double norm = gradient_norm(weights);
  if (!std::isfinite(norm)) {
    for (const auto& [name, weight] : weights) {
      if (!weight.grad().defined() || at::isfinite(weight.grad()).all().item<bool>()) continue;
      throw Error(fmt::format("the gradient of {} is not finite", name));
    }
    throw Error("the gradients are too large to be added up");
  }
  clip(weights);
  step(weights);
  ++updates_;
  clear_gradients(weights);
  return norm;
}

// Over all weights at once: a card gets a few operations in place of thousands. On the CPU these
// are loops over the same operations, weight by weight.
void WeightOptimizer::step(const Weights& weights) {
  const models::AdamConfig& rates = config_.rates;
  const double rate = this->rate();
  std::vector<at::Tensor> learning, gradients, first, second;
  for (const auto& [name, weight] : weights) {
    if (!weight.grad().defined()) continue;
    learning.push_back(weight);
    gradients.push_back(weight.grad());
    second.push_back(second_.try_emplace(name, at::zeros_like(weight)).first->second);
    if (has_first()) {
      first.push_back(first_.try_emplace(name, at::zeros_like(weight)).first->second);
    }
  }
  if (learning.empty()) return;
  if (config_.kind == models::Optimizer::kAdamW) {
    at::_foreach_mul_(learning, 1 - rate * rates.weight_decay);
  }
  if (config_.kind == models::Optimizer::kAdam && rates.weight_decay > 0) {
    gradients = at::_foreach_add(gradients, learning, rates.weight_decay);
  }
  at::_foreach_mul_(second, rates.beta2);
  at::_foreach_addcmul_(second, gradients, gradients, 1 - rates.beta2);
  std::vector<at::Tensor> scales = at::_foreach_sqrt(second);
  if (!has_first()) {
    at::_foreach_add_(scales, rates.epsilon);
    at::_foreach_addcdiv_(learning, gradients, scales, -rate);
    return;
  }
  at::_foreach_mul_(first, rates.beta1);
  at::_foreach_add_(first, gradients, 1 - rates.beta1);
  const auto t = static_cast<double>(updates_ + 1);
  const double first_share = 1 - std::pow(rates.beta1, t);
  const double second_share = 1 - std::pow(rates.beta2, t);
  at::_foreach_div_(scales, std::sqrt(second_share));
  at::_foreach_add_(scales, rates.epsilon);
  at::_foreach_addcdiv_(learning, first, scales, -rate / first_share);
}

Weights WeightOptimizer::state(const Weights& weights) const {
  Weights all;
  const auto add = [&](const Weights& moments, const char* prefix, const std::string& name,
                       const at::Tensor& weight) {
    const auto found = moments.find(name);
    all.emplace(prefix + name,
                found != moments.end() ? found->second : at::zeros_like(weight.detach()));
  };
  for (const auto& [name, weight] : weights) {
    all.emplace(name, weight.detach());
    if (has_first()) add(first_, kFirst, name, weight);
    add(second_, kSecond, name, weight);
  }
  all.emplace(kUpdates, count_tensor(updates_));
  return all;
}

void WeightOptimizer::load(const Weights& weights, const features::TensorFile& file) {
  std::vector<ArraySpec> wanted;
  for (const auto& [name, weight] : weights) {
    const std::vector<std::int64_t> shape = weight.sizes().vec();
    wanted.push_back({name, shape});
    if (has_first()) wanted.push_back({kFirst + name, shape});
    wanted.push_back({kSecond + name, shape});
  }
  wanted.push_back({kUpdates, {2}});
  const Weights read = read_weights(file, wanted);
  const c10::NoGradGuard no_gradients;
  first_.clear();
  second_.clear();
  for (const auto& [name, weight] : weights) {
    at::Tensor(weight).copy_(read.at(name));
    const c10::Device device = weight.device();
    if (has_first()) first_.emplace(name, read.at(kFirst + name).to(device));
    second_.emplace(name, read.at(kSecond + name).to(device));
  }
  const at::Tensor count = read.at(kUpdates);
  updates_ = static_cast<std::uint64_t>(count[0].item<double>()) * kHalf +
             static_cast<std::uint64_t>(count[1].item<double>());
}

}  // namespace enfilade::neural::core
