#include "enfilade/tasks/bootstrap.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/core/threads.h"

namespace enfilade::tasks {
namespace {

void validate(std::size_t values, std::size_t columns, std::size_t rows,
              const BootstrapOptions& options) {
  if (rows == 0) throw ArgumentError("bootstrap: no values to take a mean of");
  if (values != rows * columns) {
    throw ArgumentError(
        fmt::format("bootstrap: {} values, not {} rows of {} columns", values, rows, columns));
  }
  if (!(options.confidence > 0 && options.confidence < 1)) {
    throw ArgumentError(
        fmt::format("bootstrap: confidence {} is not between 0 and 1", options.confidence));
  }
  if (options.samples < 0) {
    throw ArgumentError(
        fmt::format("bootstrap: {} samples; 0 or more are allowed", options.samples));
  }
}

// What drawing groups needs: their sizes and the sums of their columns.
class Groups {
 public:
  Groups(std::span<const double> values, std::size_t columns, std::span<const std::size_t> groups)
      : columns_(columns) {
    std::unordered_map<std::size_t, std::size_t> places;  // in the order of appearance
    for (std::size_t i = 0; i < groups.size(); ++i) {
      const std::size_t g = places.try_emplace(groups[i], places.size()).first->second;
      if (g == sizes_.size()) {
        sizes_.push_back(0);
        sums_.resize(sums_.size() + columns, 0);
      }
      ++sizes_[g];
      for (std::size_t c = 0; c < columns; ++c) sums_[g * columns + c] += values[i * columns + c];
    }
  }

  // The means of one sample, into `means`.
  void draw(Rng rng, std::span<double> means) const {
    std::ranges::fill(means, 0);
    std::size_t rows = 0;
    for (std::size_t k = 0; k < sizes_.size(); ++k) {
      const std::size_t g = rng.below(sizes_.size());
      rows += sizes_[g];
      for (std::size_t c = 0; c < columns_; ++c) means[c] += sums_[g * columns_ + c];
    }
    for (double& mean : means) mean /= static_cast<double>(rows);
  }

 private:
  std::size_t columns_;
  std::vector<double> sums_;  // shape (groups, columns)
  std::vector<std::size_t> sizes_;
};

// Interpolated between the two nearest ranks. Not if these are equal or the lower one is -inf:
// inf - inf is NaN.
double percentile(const std::vector<double>& sorted, double p) {
  const double rank = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const double low = sorted[below];
  const double high = sorted[std::min(below + 1, sorted.size() - 1)];
  const double part = rank - static_cast<double>(below);
  const bool whole = low == high || part == 0 || low == -std::numeric_limits<double>::infinity();
  return whole ? low : low + part * (high - low);
}

std::vector<MeanInterval> plain_means(std::span<const double> values, std::size_t columns) {
  std::vector<MeanInterval> means(columns);
  const std::size_t rows = columns == 0 ? 0 : values.size() / columns;
  for (std::size_t c = 0; c < columns; ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < rows; ++i) sum += values[i * columns + c];
    const double mean = sum / static_cast<double>(rows);
    means[c] = {mean, mean, mean};
  }
  return means;
}

// The means of all samples. \returns shape (columns, samples)
std::vector<double> draw_means(std::span<const double> values, std::size_t columns,
                               std::span<const std::size_t> groups,
                               const BootstrapOptions& options) {
  const Groups drawn(values, columns, groups);
  const auto samples = static_cast<std::size_t>(options.samples);
  std::vector<double> means(columns * samples);
  parallel_for(samples, 16, options.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<double> of_sample(columns);
    for (std::size_t s = begin; s < end; ++s) {
      drawn.draw(Rng(options.seed, s), of_sample);
      for (std::size_t c = 0; c < columns; ++c) means[c * samples + s] = of_sample[c];
    }
  });
  return means;
}

// A column of draw_means(), sorted.
std::vector<double> sorted_column(const std::vector<double>& means, std::size_t column,
                                  std::size_t samples) {
  const auto of_column = std::span(means).subspan(column * samples, samples);
  std::vector<double> sorted(of_column.begin(), of_column.end());
  std::ranges::sort(sorted);
  return sorted;
}

void set_interval(MeanInterval& mean, const std::vector<double>& sorted, double confidence) {
  mean.low = percentile(sorted, (1 - confidence) / 2);
  mean.high = percentile(sorted, (1 + confidence) / 2);
}

// Two infinite values that are equal differ by 0, not NaN.
double difference_of(double first, double second) { return first == second ? 0 : second - first; }

// Twice the smaller share of draws on one side of zero. Draws at zero are on both.
double two_sided_p(const std::vector<double>& sorted) {
  const auto not_above = std::ranges::upper_bound(sorted, 0.0) - sorted.begin();
  const auto not_below = sorted.end() - std::ranges::lower_bound(sorted, 0.0);
  const auto smaller = static_cast<double>(std::min(not_above, not_below));
  return std::min(1.0, 2 * smaller / static_cast<double>(sorted.size()));
}

}  // namespace

std::vector<MeanInterval> bootstrap_means(std::span<const double> values, std::size_t columns,
                                          std::span<const std::size_t> groups,
                                          const BootstrapOptions& options) {
  validate(values.size(), columns, groups.size(), options);
  std::vector<MeanInterval> intervals = plain_means(values, columns);
  const auto samples = static_cast<std::size_t>(options.samples);
  if (samples == 0) return intervals;
  const std::vector<double> means = draw_means(values, columns, groups, options);
  for (std::size_t c = 0; c < columns; ++c) {
    set_interval(intervals[c], sorted_column(means, c, samples), options.confidence);
  }
  return intervals;
}

std::vector<PairedDifference> paired_bootstrap(std::span<const double> first,
                                               std::span<const double> second, std::size_t columns,
                                               std::span<const std::size_t> groups,
                                               const BootstrapOptions& options) {
  validate(first.size(), columns, groups.size(), options);
  if (second.size() != first.size()) {
    throw ArgumentError(fmt::format("bootstrap: {} values in the second table, {} in the first",
                                    second.size(), first.size()));
  }
  std::vector<double> differences(first.size());
  std::ranges::transform(first, second, differences.begin(), difference_of);
  const std::vector<MeanInterval> plain = plain_means(differences, columns);
  std::vector<PairedDifference> found(columns);
  for (std::size_t c = 0; c < columns; ++c) found[c].difference = plain[c];
  const auto samples = static_cast<std::size_t>(options.samples);
  if (samples == 0) return found;
  const std::vector<double> means = draw_means(differences, columns, groups, options);
  for (std::size_t c = 0; c < columns; ++c) {
    MeanInterval& difference = found[c].difference;
    if (std::isnan(difference.mean)) {  // +inf and -inf: no order of the draws
      constexpr double kInfinity = std::numeric_limits<double>::infinity();
      difference.low = -kInfinity;
      difference.high = kInfinity;
      continue;
    }
    const std::vector<double> sorted = sorted_column(means, c, samples);
    set_interval(difference, sorted, options.confidence);
    found[c].p = two_sided_p(sorted);
  }
  return found;
}

}  // namespace enfilade::tasks
