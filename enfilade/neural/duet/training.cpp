#include "enfilade/neural/duet/training.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <cmath>

#include "enfilade/core/errors.h"

namespace enfilade::neural::duet {
namespace {

constexpr const char* kFirst = "adam.first.";
constexpr const char* kSecond = "adam.second.";
constexpr const char* kUpdates = "adam.updates";

}  // namespace

void clear_gradients(const DuetNetwork& network) {
  for (const auto& [name, weight] : network.weights()) at::Tensor(weight).mutable_grad().reset();
}

double AdamW::update(const DuetNetwork& network) {
  const c10::NoGradGuard no_gradients;
  std::vector<at::Tensor> norms;
  for (const auto& [name, weight] : network.weights()) {
    if (!weight.grad().defined()) continue;
    norms.push_back(weight.grad().norm());
    if (std::isfinite(norms.back().item<double>())) continue;
    throw Error(fmt::format("the gradient of {} is not finite", name));
  }
  if (norms.empty()) return 0;
  const at::Tensor total = at::stack(norms).norm();
  // PyTorch's clip_grad_norm_(): 1e-6 keeps the quotient finite.
  const at::Tensor factor = (config_.clip / (total + 1e-6)).clamp_max(1.0);
  ++updates_;
  for (const auto& [name, weight] : network.weights()) {
    if (weight.grad().defined()) step(name, weight, weight.grad() * factor);
  }
  clear_gradients(network);
  return total.item<double>();
}

void AdamW::step(const std::string& name, at::Tensor weight, const at::Tensor& gradient) {
  at::Tensor& first = first_.try_emplace(name, at::zeros_like(weight)).first->second;
  at::Tensor& second = second_.try_emplace(name, at::zeros_like(weight)).first->second;
  const auto t = static_cast<double>(updates_);
  weight.mul_(1 - config_.rate * config_.weight_decay);
  first.mul_(config_.first_decay).add_(gradient, 1 - config_.first_decay);
  second.mul_(config_.second_decay).addcmul_(gradient, gradient, 1 - config_.second_decay);
  const double first_share = 1 - std::pow(config_.first_decay, t);
  const double second_share = 1 - std::pow(config_.second_decay, t);
  const at::Tensor scale = (second.sqrt() / std::sqrt(second_share)).add_(config_.epsilon);
  weight.addcdiv_(first, scale, -config_.rate / first_share);
}

void AdamW::save(const DuetNetwork& network, const std::filesystem::path& file) const {
  encoders::Weights all = network.weights();
  for (const auto& [name, weight] : network.weights()) {
    const auto found = first_.find(name);
    const bool known = found != first_.end();
    all.emplace(kFirst + name, known ? found->second : at::zeros_like(weight.detach()));
    all.emplace(kSecond + name, known ? second_.at(name) : at::zeros_like(weight.detach()));
  }
  all.emplace(kUpdates, at::full({1}, static_cast<double>(updates_), at::kFloat));
  features::write_safetensors(file, encoders::as_arrays(all));
}

void AdamW::load(DuetNetwork& network, const features::TensorFile& file) {
  std::vector<encoders::ArraySpec> wanted = arrays_of(network.config());
  for (const encoders::ArraySpec& spec : arrays_of(network.config())) {
    wanted.push_back({kFirst + spec.name, spec.shape});
    wanted.push_back({kSecond + spec.name, spec.shape});
  }
  wanted.push_back({kUpdates, {1}});
  const encoders::Weights read =
      encoders::read_weights(file, wanted, [](std::string_view) { return false; });
  const c10::NoGradGuard no_gradients;
  first_.clear();
  second_.clear();
  for (const auto& [name, weight] : network.weights()) {
    at::Tensor(weight).copy_(read.at(name));
    first_.emplace(name, read.at(kFirst + name));
    second_.emplace(name, read.at(kSecond + name));
  }
  updates_ = static_cast<std::uint64_t>(read.at(kUpdates).item<double>());
}

TrainingStep accumulate(const DuetNetwork& network, Walker& walker,
                        std::span<const TrainingWalk> walks, const StepWatcher& watcher) {
  clear_gradients(network);
  TrainingStep result;
  at::Tensor total;
  for (const TrainingWalk& part : walks) {
    const Rollout rollout = walker.walk(network, part.episodes, part.options, watcher);
    result.losses.push_back(0);
    if (!rollout.loss.defined()) continue;
    const at::Tensor loss =
        rollout.loss * (part.weight / static_cast<double>(part.episodes.size()));
    result.losses.back() = loss.item<double>();
    total = total.defined() ? total + loss : loss;
  }
  for (const double loss : result.losses) result.loss += loss;
  if (!std::isfinite(result.loss)) {
    throw Error(fmt::format("the loss is {}, not a finite number", result.loss));
  }
  if (total.defined()) total.backward();
  return result;
}

TrainingStep train_once(const DuetNetwork& network, Walker& walker,
                        std::span<const TrainingWalk> walks, AdamW& optimizer,
                        const StepWatcher& watcher) {
  TrainingStep result = accumulate(network, walker, walks, watcher);
  result.norm = optimizer.update(network);
  return result;
}

}  // namespace enfilade::neural::duet
