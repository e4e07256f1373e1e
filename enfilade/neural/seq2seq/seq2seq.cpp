#include "enfilade/neural/seq2seq/seq2seq.h"

#include <c10/core/InferenceMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"

namespace enfilade::neural::seq2seq {
namespace {

constexpr std::int64_t kFloatsALine = 16;  // floats a cache line

// Box and Muller; a uniform number is never 1, so 1 - u has a logarithm.
double normal(Rng& rng) {
  const double radius = std::sqrt(-2 * std::log(1 - rng.uniform()));
  return radius * std::cos(2 * std::numbers::pi * rng.uniform());
}

std::array<WeightInfo, kWeights> weight_infos(const models::NetworkConfig& config) {
  const auto h = static_cast<std::int64_t>(config.hidden);
  const auto words = static_cast<std::int64_t>(config.vocabulary);
  const auto embedding = static_cast<std::int64_t>(config.word_embedding);
  const auto action = static_cast<std::int64_t>(config.action_embedding);
  const auto input = action + static_cast<std::int64_t>(config.features);
  constexpr std::int64_t kInputs = kIgnoreInput + 1;
  std::array<WeightInfo, kWeights> infos{{
      {"encoder.embedding.weight", {words, embedding}, 0},
      {"encoder.lstm.weight_ih_l0", {4 * h, embedding}, h},
      {"encoder.lstm.weight_hh_l0", {4 * h, h}, h},
      {"encoder.lstm.bias_ih_l0", {4 * h}, h},
      {"encoder.lstm.bias_hh_l0", {4 * h}, h},
      {"encoder.encoder2decoder.weight", {h, h}, h},
      {"encoder.encoder2decoder.bias", {h}, h},
      {"decoder.embedding.weight", {kInputs, action}, 0},
      {"decoder.lstm.weight_ih", {4 * h, input}, h},
      {"decoder.lstm.weight_hh", {4 * h, h}, h},
      {"decoder.lstm.bias_ih", {4 * h}, h},
      {"decoder.lstm.bias_hh", {4 * h}, h},
      {"decoder.attention_layer.linear_in.weight", {h, h}, h},
      {"decoder.attention_layer.linear_out.weight", {h, 2 * h}, 2 * h},
      {"decoder.decoder2action.weight", {kSixActionCount, h}, h},
      {"decoder.decoder2action.bias", {kSixActionCount}, h},
  }};
  std::int64_t begin = 0;
  for (WeightInfo& info : infos) {
    info.begin = begin;
    info.elements = 1;
    for (const std::int64_t n : info.shape) info.elements *= n;
    begin += (info.elements + kFloatsALine - 1) / kFloatsALine * kFloatsALine;
  }
  return infos;
}

constexpr auto kForward = static_cast<std::size_t>(SixAction::kForward);

using Probabilities = std::array<double, kLogits>;

Probabilities softmax(std::span<const double> logits) {
  const double most = *std::max_element(logits.begin(), logits.end());
  Probabilities result{};
  double sum = 0;
  for (std::size_t a = 0; a < kLogits; ++a) sum += result[a] = std::exp(logits[a] - most);
  for (double& p : result) p /= sum;
  return result;
}

std::int32_t drawn(std::span<const double> logits, double uniform) {
  const Probabilities probabilities = softmax(logits);
  double sum = 0;
  std::int32_t possible = 0;  // the last one, if rounding leaves the sum below 1
  for (std::size_t a = 0; a < kLogits; ++a) {
    if (probabilities[a] > 0) possible = static_cast<std::int32_t>(a);
    sum += probabilities[a];
    if (uniform < sum) break;
  }
  return possible;
}

}  // namespace

Network::Network(const models::NetworkConfig& config, const at::TensorOptions& options,
                 std::unique_ptr<NetworkKernels> kernels)
    : config_(core::checked(config)),
      kernels_(std::move(kernels)),
      parameters_(config_, options),
      encoder_(parameters_, *kernels_),
      decoder_(config_, parameters_, *kernels_) {}

Choices Network::RolloutMemory::choices(std::size_t step) {
  return {logits, std::span(forward_open).subspan(step * n, n),
          labelled ? std::span<const std::int32_t>(labels).subspan(step * n, n)
                   : std::span<const std::int32_t>()};
}

std::span<double> Network::RolloutMemory::gradient_of(std::size_t step) {
  if (gradient.empty()) return {};
  return std::span(gradient).subspan(step * n * kLogits, n * kLogits);
}

void Network::RolloutMemory::read(const at::Tensor& step_logits) {
  const std::array<std::int64_t, 2> shape{static_cast<std::int64_t>(n), kSixActionCount};
  at::from_blob(logits.data(), shape, at::TensorOptions().dtype(at::kDouble)).copy_(step_logits);
}

void Network::check(const InstructionBatch& instructions, const Environment& environment,
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

void Network::begin_rollout(const Environment& environment, const RolloutOptions& options,
                            WithGradients with_gradients) {
  RolloutMemory& w = memory_;
  w.n = environment.size();
  w.steps = options.max_steps;
  w.environment = {};
  w.labelled = environment.has_teacher();
  w.inputs.assign(w.n, kStartInput);
  w.actions.assign(w.n, 0);
  w.forward_open.assign(w.steps * w.n, 0);
  w.labels.assign(w.labelled ? w.steps * w.n : 0, kIgnoreLabel);
  w.features.resize(w.n * environment.dimensions());
  w.logits.resize(w.n * kLogits);
  w.gradient.resize(with_gradients == WithGradients::kYes ? w.steps * w.n * kLogits : 0);
}

RolloutResult Network::rollout(const InstructionBatch& instructions, Environment& environment,
                               const RolloutOptions& options, WithGradients with_gradients,
                               const StepObserver& observer,
                               const std::function<void()>& decoder_done) {
  const c10::InferenceMode guard;
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
  const RolloutDropout dropout{options.seed, options.stream, options.dropout ? config_.dropout : 0};
  begin_rollout(environment, options, with_gradients);
  decoder_.begin(static_cast<std::int64_t>(instructions.size),
                 static_cast<std::int64_t>(options.max_steps), gradients || taught, dropout);
  const SentenceContext context =
      encoder_.forward(sentences, dropout, decoder_.start(), decoder_.start_cells());
  RolloutResult result = taught ? rollout_as_taught(context, environment, options)
                                : run(context, environment, options, observer);
  if (gradients) backward(sentences, context, dropout, result.steps, decoder_done);
  result.environment_seconds = std::chrono::duration<double>(memory_.environment).count();
  return result;
}

void Network::observe(Environment& environment, std::size_t step) {
  RolloutMemory& w = memory_;
  const std::span<std::int32_t> labels(w.labels);
  const auto begin = std::chrono::steady_clock::now();
  environment.observe({w.features, std::span(w.forward_open).subspan(step * w.n, w.n),
                       w.labelled ? labels.subspan(step * w.n, w.n) : labels});
  w.environment += std::chrono::steady_clock::now() - begin;
  check_labels(w.choices(step));
  put_inputs(step);
}

bool Network::move(Environment& environment) {
  const auto begin = std::chrono::steady_clock::now();
  const bool more = environment.step(memory_.actions);
  memory_.environment += std::chrono::steady_clock::now() - begin;
  memory_.inputs = memory_.actions;
  return more;
}

void Network::put_inputs(std::size_t step) {
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

void Network::advance(const SentenceContext& context, std::size_t step) {
  const auto t = static_cast<std::int64_t>(step);
  decoder_.multiply_inputs(t, 1);
  decoder_.recur(t);
  memory_.read(decoder_.attend(context, t, 1));
}

RolloutResult Network::run(const SentenceContext& context, Environment& environment,
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
    more = move(environment);
  }
  return result;
}

RolloutResult Network::rollout_as_taught(const SentenceContext& context, Environment& environment,
                                         const RolloutOptions& options) {
  RolloutMemory& w = memory_;
  RolloutResult result;
  for (bool more = true; more && result.steps < w.steps; ++result.steps) {
    observe(environment, result.steps);
    choose(w.choices(result.steps), options, result.steps, w.actions);
    more = move(environment);
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

void Network::begin(const InstructionBatch& instructions, std::size_t max_steps) {
  const c10::InferenceMode guard;
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
    const RolloutDropout none{0, 0, 0};
    decoder_.begin(static_cast<std::int64_t>(w.n), static_cast<std::int64_t>(max_steps), false,
                   none);
    begun.context =
        encoder_.forward(begun.sentences, none, decoder_.start(), decoder_.start_cells());
  }
  begun_ = std::move(begun);
  if (w.n > 0) begun_->context.lengths = begun_->sentences.lengths;
}

void Network::act(std::span<const float> features, std::span<const std::uint8_t> forward_open,
                  std::span<std::int32_t> actions) {
  const c10::InferenceMode guard;
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

void Network::backward(const Sentences& sentences, const SentenceContext& context,
                       const RolloutDropout& dropout, std::size_t steps,
                       const std::function<void()>& decoder_done) {
  const std::array<std::int64_t, 2> shape{static_cast<std::int64_t>(steps * memory_.n),
                                          kSixActionCount};
  const at::Tensor gradient =
      at::from_blob(memory_.gradient.data(), shape, at::TensorOptions().dtype(at::kDouble))
          .to(parameters_.flat_weights.options());
  const ActionDecoder::Gradients back = decoder_.backward(context, gradient);
  if (decoder_done) decoder_done();
  encoder_.backward(sentences, dropout, back.context, decoder_.start(), back.start, back.cells);
}

void Network::tell(const StepObserver& observer, std::size_t step) const {
  const auto host = at::TensorOptions().dtype(at::kFloat).device(at::kCPU);
  const at::Tensor attention =
      decoder_.attention(static_cast<std::int64_t>(step)).to(host).contiguous();
  const std::vector<float> logits(memory_.logits.begin(), memory_.logits.end());
  const auto words = static_cast<std::size_t>(attention.size(1));
  observer(
      {step, {attention.data_ptr<float>(), memory_.n * words}, words, logits, memory_.actions});
}

void Network::update(const models::AdamConfig& config) {
  const c10::InferenceMode guard;
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

Parameters::Parameters(const models::NetworkConfig& config, const at::TensorOptions& options)
    : infos_(weight_infos(config)) {
  const c10::InferenceMode guard;
  const WeightInfo& last = infos_.back();
  const std::int64_t size = last.begin + last.elements;
  flat_weights = at::zeros({size}, options);
  flat_gradients = at::zeros({size}, options);
  first = at::zeros({size}, options);
  second = at::zeros({size}, options);
  for (std::size_t i = 0; i < kWeights; ++i) {
    weights_[i] = view(flat_weights, i);
    gradients_[i] = view(flat_gradients, i);
  }
}

void Parameters::initialise(std::uint64_t seed) {
  const c10::InferenceMode guard;
  const at::Tensor host = at::zeros(flat_weights.sizes(), at::TensorOptions().dtype(at::kFloat));
  for (std::size_t i = 0; i < kWeights; ++i) {
    const WeightInfo& info = infos_[i];
    const double most = info.inputs > 0 ? 1 / std::sqrt(static_cast<double>(info.inputs)) : 0;
    Rng rng(seed, i);
    float* out = host.data_ptr<float>() + info.begin;
    for (std::int64_t k = 0; k < info.elements; ++k) {
      out[k] = static_cast<float>(most > 0 ? most * (2 * rng.uniform() - 1) : normal(rng));
    }
    if (i == index(Weight::kWordEmbedding)) std::fill_n(out, info.shape[1], 0.0F);
  }
  flat_weights.copy_(host);
  for (const at::Tensor& other : {flat_gradients, first, second}) other.zero_();
  updates = 0;
}

at::Tensor Parameters::view(const at::Tensor& flat, std::size_t i) const {
  return flat.narrow(0, infos_[i].begin, infos_[i].elements).view(infos_[i].shape);
}

void check_labels(const Choices& step) {
  for (std::size_t r = 0; r < step.labels.size(); ++r) {
    const std::int32_t label = step.labels[r];
    if (label < kIgnoreLabel || label >= kSixActionCount) {
      throw ArgumentError(fmt::format("environment: label {} of episode {}, not from {} to {}",
                                      label, r, kIgnoreLabel, kSixActionCount - 1));
    }
    if (label == static_cast<std::int32_t>(kForward) && step.forward_open[r] == 0) {
      throw ArgumentError(
          fmt::format("environment: label forward of episode {}, where forward is closed", r));
    }
  }
}

double loss(const Choices& step, std::span<double> gradient) {
  for (std::size_t r = 0; r < step.forward_open.size(); ++r) {
    if (step.forward_open[r] == 0) {
      step.logits[r * kLogits + kForward] = -std::numeric_limits<double>::infinity();
    }
  }
  std::fill(gradient.begin(), gradient.end(), 0.0);
  const auto counting = static_cast<double>(
      std::count_if(step.labels.begin(), step.labels.end(), [](auto l) { return l >= 0; }));
  double sum = 0;
  for (std::size_t r = 0; r < step.labels.size(); ++r) {
    if (step.labels[r] < 0) continue;
    const auto label = static_cast<std::size_t>(step.labels[r]);
    const std::span<const double> logits = step.logits.subspan(r * kLogits, kLogits);
    const Probabilities probabilities = softmax(logits);
    // The probability of a very unlikely label may round to 0; this logarithm stays finite.
    const double most = *std::max_element(logits.begin(), logits.end());
    double total = 0;
    for (const double logit : logits) total += std::exp(logit - most);
    sum += most + std::log(total) - logits[label];
    if (gradient.empty()) continue;
    for (std::size_t a = 0; a < kLogits; ++a) {
      gradient[r * kLogits + a] = (probabilities[a] - (a == label ? 1 : 0)) / counting;
    }
  }
  return counting > 0 ? sum / counting : 0;
}

void choose(const Choices& step, const RolloutOptions& options, std::size_t step_number,
            std::span<std::int32_t> actions) {
  for (std::size_t r = 0; r < actions.size(); ++r) {
    const std::span<const double> logits = step.logits.subspan(r * kLogits, kLogits);
    switch (options.feedback) {
      case models::Feedback::kTeacher:
        actions[r] = step.labels[r] < 0 ? kIgnoreInput : step.labels[r];
        break;
      case models::Feedback::kSample:
        actions[r] = drawn(logits, draw_uniform(options.seed, options.stream,
                                                {static_cast<std::uint32_t>(step_number),
                                                 static_cast<std::uint32_t>(r)}));
        break;
      case models::Feedback::kArgmax:
        actions[r] = static_cast<std::int32_t>(std::max_element(logits.begin(), logits.end()) -
                                               logits.begin());
        break;
    }
  }
}

}  // namespace enfilade::neural::seq2seq
