#include "enfilade/neural/seq2seq/choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "enfilade/core/errors.h"
#include "enfilade/neural/seq2seq/dropout.h"

namespace enfilade::neural::seq2seq {
namespace {

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
