#include "enfilade/neural/seq2seq/seq2seq.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::neural::seq2seq {
namespace {

models::NetworkConfig checked(const models::NetworkConfig& config) {
  validate(config);
  return config;
}

}  // namespace

Seq2Seq::Seq2Seq(const models::NetworkConfig& config, const at::TensorOptions& options,
                 std::unique_ptr<Kernels> kernels)
    : config_(checked(config)),
      kernels_(std::move(kernels)),
      parameters_(config_, options),
      encoder_(parameters_, *kernels_),
      decoder_(config_, parameters_, *kernels_) {}

Choices Seq2Seq::RolloutMemory::choices(std::size_t step) {
  return {logits, std::span(forward_open).subspan(step * n, n),
          labelled ? std::span<const std::int32_t>(labels).subspan(step * n, n)
                   : std::span<const std::int32_t>()};
}

std::span<double> Seq2Seq::RolloutMemory::gradient_of(std::size_t step) {
  if (gradient.empty()) return {};
  return std::span(gradient).subspan(step * n * kLogits, n * kLogits);
}

void Seq2Seq::RolloutMemory::read(const at::Tensor& step_logits) {
  const std::array<std::int64_t, 2> shape{static_cast<std::int64_t>(n), kSixActionCount};
  at::from_blob(logits.data(), shape, at::TensorOptions().dtype(at::kDouble)).copy_(step_logits);
}

void Seq2Seq::check(const InstructionBatch& instructions, const Environment& environment,
                    const RolloutOptions& options, WithGradients with_gradients) const {
  if (environment.size() != instructions.size) {
    throw ArgumentError(fmt::format("{} instructions for an environment of {} episodes",
                                    instructions.size, environment.size()));
  }
  if (config_.inputs.vision && environment.dimensions() != config_.features) {
    throw ArgumentError(fmt::format("the environment has features of {} numbers, the network {}",
                                    environment.dimensions(), config_.features));
  }
  if (options.max_steps < 1) throw ArgumentError("max_steps: 0, at least 1");
  if (environment.has_teacher()) return;
  if (options.feedback == models::Feedback::kTeacher) {
    throw ArgumentError("feedback teacher: the environment has no teacher");
  }
  if (with_gradients == WithGradients::kYes) {
    throw ArgumentError("gradients: the environment has no teacher, so there is no loss");
  }
}

void Seq2Seq::begin_rollout(const Environment& environment, const RolloutOptions& options,
                            WithGradients with_gradients) {
  RolloutMemory& w = memory_;
  w.n = environment.size();
  w.steps = options.max_steps;
  w.labelled = environment.has_teacher();
  w.inputs.assign(w.n, kStartInput);
  w.actions.assign(w.n, 0);
  w.forward_open.assign(w.steps * w.n, 0);
  w.labels.assign(w.labelled ? w.steps * w.n : 0, kIgnoreLabel);
  w.features.resize(w.n * environment.dimensions());
  w.logits.resize(w.n * kLogits);
  w.gradient.resize(with_gradients == WithGradients::kYes ? w.steps * w.n * kLogits : 0);
}

RolloutResult Seq2Seq::rollout(const InstructionBatch& instructions, Environment& environment,
                               const RolloutOptions& options, WithGradients with_gradients,
                               const StepObserver& observer,
                               const std::function<void()>& decoder_done) {
  check(instructions, environment, options, with_gradients);
  begun_.reset();
  const Sentences sentences = lay_out(instructions, config_);
  const bool gradients = with_gradients == WithGradients::kYes;
  if (instructions.size == 0) {
    if (gradients) parameters_.flat_gradients.zero_();
    return {};
  }
  // The teacher's actions do not depend on the network: all steps can be walked beforehand.
  const bool taught = options.feedback == models::Feedback::kTeacher && !observer;
  const Dropout dropout{options.seed, options.stream, options.dropout ? config_.dropout : 0};
  begin_rollout(environment, options, with_gradients);
  decoder_.begin(static_cast<std::int64_t>(instructions.size),
                 static_cast<std::int64_t>(options.max_steps), gradients || taught, dropout);
  const Context context =
      encoder_.forward(sentences, dropout, decoder_.start(), decoder_.start_cells());
  const RolloutResult result = taught ? rollout_as_taught(context, environment, options)
                                      : run(context, environment, options, observer);
  if (gradients) backward(sentences, context, dropout, result.steps, decoder_done);
  return result;
}

void Seq2Seq::observe(Environment& environment, std::size_t step) {
  RolloutMemory& w = memory_;
  const std::span<std::int32_t> labels(w.labels);
  environment.observe({w.features, std::span(w.forward_open).subspan(step * w.n, w.n),
                       w.labelled ? labels.subspan(step * w.n, w.n) : labels});
  check_labels(w.choices(step));
  put_inputs(step);
}

void Seq2Seq::put_inputs(std::size_t step) {
  RolloutMemory& w = memory_;
  at::Tensor features;
  if (config_.inputs.vision) {
    const std::array<std::int64_t, 2> shape{static_cast<std::int64_t>(w.n),
                                            static_cast<std::int64_t>(config_.features)};
    features = at::from_blob(w.features.data(), shape, at::TensorOptions().dtype(at::kFloat))
                   .to(parameters_.flat_weights.options());
  }
  decoder_.put_inputs(static_cast<std::int64_t>(step), w.inputs, features);
}

void Seq2Seq::advance(const Context& context, std::size_t step) {
  const auto t = static_cast<std::int64_t>(step);
  decoder_.multiply_inputs(t, 1);
  decoder_.recur(t);
  memory_.read(decoder_.attend(context, t, 1));
}

RolloutResult Seq2Seq::run(const Context& context, Environment& environment,
                           const RolloutOptions& options, const StepObserver& observer) {
  RolloutMemory& w = memory_;
  RolloutResult result;
  for (bool more = true; more && result.steps < w.steps; ++result.steps) {
    const std::size_t step = result.steps;
    observe(environment, step);
    advance(context, step);
    result.loss += loss(w.choices(step), w.gradient_of(step));
    choose(w.choices(step), options, step, w.actions);
    if (observer) tell(observer, step);
    more = environment.step(w.actions);
    w.inputs = w.actions;
  }
  return result;
}

RolloutResult Seq2Seq::rollout_as_taught(const Context& context, Environment& environment,
                                         const RolloutOptions& options) {
  RolloutMemory& w = memory_;
  RolloutResult result;
  for (bool more = true; more && result.steps < w.steps; ++result.steps) {
    observe(environment, result.steps);
    choose(w.choices(result.steps), options, result.steps, w.actions);
    more = environment.step(w.actions);
    w.inputs = w.actions;
  }
  const auto steps = static_cast<std::int64_t>(result.steps);
  decoder_.multiply_inputs(0, steps);
  for (std::int64_t t = 0; t < steps; ++t) decoder_.recur(t);
  const at::Tensor logits = decoder_.attend(context, 0, steps);
  for (std::size_t step = 0; step < result.steps; ++step) {
    const auto n = static_cast<std::int64_t>(w.n);
    w.read(logits.narrow(0, static_cast<std::int64_t>(step) * n, n));
    result.loss += loss(w.choices(step), w.gradient_of(step));
  }
  return result;
}

void Seq2Seq::begin(const InstructionBatch& instructions, std::size_t max_steps) {
  begun_.reset();
  RolloutMemory& w = memory_;
  w.n = instructions.size;
  w.labelled = false;
  w.inputs.assign(w.n, kStartInput);
  w.actions.assign(w.n, 0);
  w.forward_open.assign(w.n, 0);
  w.features.assign(w.n * config_.features, 0);
  w.logits.resize(w.n * kLogits);
  Begun begun{lay_out(instructions, config_), {}, 0, max_steps};
  if (w.n > 0) {
    const Dropout none{0, 0, 0};
    decoder_.begin(static_cast<std::int64_t>(w.n), static_cast<std::int64_t>(max_steps), false,
                   none);
    begun.context =
        encoder_.forward(begun.sentences, none, decoder_.start(), decoder_.start_cells());
  }
  begun_ = std::move(begun);
  if (w.n > 0) begun_->context.lengths = begun_->sentences.lengths;
}

void Seq2Seq::act(std::span<const float> features, std::span<const std::uint8_t> forward_open,
                  std::span<std::int32_t> actions) {
  RolloutMemory& w = memory_;
  if (!begun_) throw ArgumentError("act() without begin()");
  if (begun_->steps == begun_->max_steps) {
    throw ArgumentError(fmt::format("act() after the {} steps of begin()", begun_->max_steps));
  }
  if (forward_open.size() != w.n || actions.size() != w.n || features.size() != w.features.size()) {
    throw ArgumentError(fmt::format(
        "act(): {} features, {} forward_open and {} actions for {} episodes of {} features each",
        features.size(), forward_open.size(), actions.size(), w.n, config_.features));
  }
  const std::size_t step = begun_->steps++;
  if (w.n == 0) return;
  std::ranges::copy(features, w.features.begin());
  std::ranges::copy(forward_open, w.forward_open.begin());
  put_inputs(step);
  advance(begun_->context, step);
  loss(w.choices(0), {});  // sets the logits of closed actions
  choose(w.choices(0), RolloutOptions{}, step, w.actions);
  w.inputs = w.actions;
  std::ranges::copy(w.actions, actions.begin());
}

void Seq2Seq::backward(const Sentences& sentences, const Context& context, const Dropout& dropout,
                       std::size_t steps, const std::function<void()>& decoder_done) {
  const std::array<std::int64_t, 2> shape{static_cast<std::int64_t>(steps * memory_.n),
                                          kSixActionCount};
  const at::Tensor gradient =
      at::from_blob(memory_.gradient.data(), shape, at::TensorOptions().dtype(at::kDouble))
          .to(parameters_.flat_weights.options());
  const ActionDecoder::Gradients back = decoder_.backward(context, gradient);
  if (decoder_done) decoder_done();
  encoder_.backward(sentences, dropout, back.context, decoder_.start(), back.start, back.cells);
}

void Seq2Seq::tell(const StepObserver& observer, std::size_t step) const {
  const auto host = at::TensorOptions().dtype(at::kFloat).device(at::kCPU);
  const at::Tensor attention =
      decoder_.attention(static_cast<std::int64_t>(step)).to(host).contiguous();
  const std::vector<float> logits(memory_.logits.begin(), memory_.logits.end());
  const auto words = static_cast<std::size_t>(attention.size(1));
  observer(
      {step, {attention.data_ptr<float>(), memory_.n * words}, words, logits, memory_.actions});
}

void Seq2Seq::update(const models::AdamConfig& config) {
  if (!kernels_->all_finite(parameters_.flat_gradients)) {
    for (std::size_t i = 0; i < kWeights; ++i) {
      if (parameters_.view(parameters_.flat_gradients, i).isfinite().all().item<bool>()) continue;
      throw Error(fmt::format("the gradient of {} is not finite: nothing was updated",
                              parameters_.infos()[i].name));
    }
  }
  ++parameters_.updates;
  kernels_->adam(config, parameters_.updates, parameters_.flat_weights, parameters_.flat_gradients,
                 parameters_.first, parameters_.second);
}

}  // namespace enfilade::neural::seq2seq
