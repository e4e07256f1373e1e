#include "enfilade/tasks/bootstrap.h"

#include <fmt/format.h>
#include <algorithm>
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

// Interpolated between the two nearest ranks; not if these are equal, because inf - inf is NaN.
double percentile(const std::vector<double>& sorted, double p) {
  const double rank = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const double low = sorted[below];
  const double high = sorted[std::min(below + 1, sorted.size() - 1)];
  const double part = rank - static_cast<double>(below);
  return low == high || part == 0 ? low : low + part * (high - low);
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

}  // namespace

std::vector<MeanInterval> bootstrap_means(std::span<const double> values, std::size_t columns,
                                          std::span<const std::size_t> groups,
                                          const BootstrapOptions& options) {
  validate(values.size(), columns, groups.size(), options);
  std::vector<MeanInterval> intervals = plain_means(values, columns);
  const auto samples = static_cast<std::size_t>(options.samples);
  if (samples == 0) return intervals;
  const Groups drawn(values, columns, groups);
  std::vector<double> means(samples * columns);
  parallel_for(samples, 16, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      drawn.draw(Rng(options.seed, s), std::span(means).subspan(s * columns, columns));
    }
  });
  std::vector<double> column(samples);
  for (std::size_t c = 0; c < columns; ++c) {
    for (std::size_t s = 0; s < samples; ++s) column[s] = means[s * columns + c];
    std::ranges::sort(column);
    intervals[c].low = percentile(column, (1 - options.confidence) / 2);
    intervals[c].high = percentile(column, (1 + options.confidence) / 2);
  }
  return intervals;
}

}  // namespace enfilade::tasks
