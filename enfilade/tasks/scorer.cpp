#include "enfilade/tasks/scorer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks {
namespace {

using enum MeanRule;

double mean(const Scorer& scorer, std::size_t metric, std::span<const double> values) {
  const std::size_t width = scorer.metrics.size();
  const MeanRule rule = scorer.metrics[metric].rule;
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t at = metric; at < values.size(); at += width) {
    if (rule == kWhereDefined && std::isnan(values[at])) continue;
    sum += values[at];
    ++n;
  }
  if (rule == kNone || n == 0) return std::numeric_limits<double>::quiet_NaN();
  constexpr double kGuard = 1e-9;  // SOON's released scorer adds it to the number of episodes
  return sum / (static_cast<double>(n) + (rule == kGuarded ? kGuard : 0)) *
         scorer.metrics[metric].scale;
}

}  // namespace

std::size_t Scorer::place_of(std::string_view mean_name) const {
  const auto found = std::ranges::find_if(
      metrics, [mean_name](const ScorerMetric& m) { return mean_name == m.mean_name(); });
  if (found != metrics.end()) return static_cast<std::size_t>(found - metrics.begin());
  std::vector<std::string_view> names;
  for (const ScorerMetric& one : metrics) names.emplace_back(one.mean_name());
  throw LookupError(fmt::format("no metric {:?}; there are {}", mean_name, fmt::join(names, ", ")));
}

const Scorer& own_scorer() noexcept { return scorers::kR2r.front(); }

const Measure* find_measure(std::span<const Measure> measures, std::string_view name) noexcept {
  const auto found = std::ranges::find(measures, name, &Measure::name);
  return found == measures.end() ? nullptr : &*found;
}

std::vector<double> summarise(const Scorer& scorer, std::span<const double> values) {
  const std::size_t width = scorer.metrics.size();
  EN_CHECK_EQ(values.size() % width, std::size_t{0});
  std::vector<double> means(width);
  for (std::size_t metric = 0; metric < width; ++metric) {
    means[metric] = mean(scorer, metric, values);
  }
  return means;
}

}  // namespace enfilade::tasks
