/// \file  Bootstrap intervals of means whose samples come in groups.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace enfilade::tasks {

/// A mean with its interval.
struct MeanInterval {
  double mean = 0;
  double low = 0;
  double high = 0;
};

/// How intervals are computed.
struct BootstrapOptions {
  int samples = 1000;        ///< 0: no intervals, low = high = mean
  double confidence = 0.95;  ///< in (0, 1)
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: all cores; never changes a result
};

/// The mean of each column and its percentile bootstrap interval. Each draw, with replacement, is a
/// *group* with all its rows. Rows of one group (the three instructions of a path) are not
/// independent samples, and drawing rows would give too narrow intervals
/// (docs/design/bootstrap.md). All columns share the draws. Deterministic. `values`: shape (rows,
/// columns), row-major. `groups`: shape (rows), equal numbers are one group.
/// \throws ArgumentError for no rows, shapes that don't fit, a confidence outside (0, 1), a
/// negative number of samples
std::vector<MeanInterval> bootstrap_means(std::span<const double> values, std::size_t columns,
                                          std::span<const std::size_t> groups,
                                          const BootstrapOptions& options = {});

/// How much the mean of one column differs between two sets of results of the same rows.
struct PairedDifference {
  MeanInterval difference;  ///< of (second - first), with its interval
  /// Two-sided: twice the smaller share of draws on one side of zero, draws at zero on both; in
  /// [0, 1]. 1 without draws (samples = 0).
  double p = 1;
};

/// The paired bootstrap: draws groups as bootstrap_means(), of the row-wise differences second -
/// first, so both sets of results have the same rows in each draw. `first`, `second`: shape (rows,
/// columns), row-major, the same rows in the same order. `groups`: shape (rows). Deterministic.
/// Two equal infinite values differ by 0. A NaN, or differences of +inf and -inf in one column:
/// mean NaN, interval (-inf, inf), p = 1.
/// Source: Efron and Tibshirani, An Introduction to the Bootstrap (1993), chapters 8 and 15.
/// \throws ArgumentError as bootstrap_means(); for tables of different sizes
std::vector<PairedDifference> paired_bootstrap(std::span<const double> first,
                                               std::span<const double> second, std::size_t columns,
                                               std::span<const std::size_t> groups,
                                               const BootstrapOptions& options = {});

}  // namespace enfilade::tasks
