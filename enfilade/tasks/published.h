/// \file  Figures that others have published of the benchmarks, each with where it was read. They
/// stand beside results on real data only.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/tasks/benchmark.h"

namespace enfilade::tasks {

/// One number of a published row.
struct PublishedFigure {
  std::string_view column = {};  ///< as Measure::column: "SR"; empty: none
  double value = 0;              ///< metres, or a share in [0, 1]
};

/// A row that was published, as it stands in its source.
struct PublishedResult {
  std::string_view benchmark;  ///< its name: "r2r-ce"
  std::string_view split;      ///< "val_unseen"
  std::string_view agent;      ///< "NaviLLM"; "Human"
  std::string_view source;     ///< where it was read
  std::size_t episodes = 0;    ///< of the split that it is of; 0: the source does not say
  std::array<PublishedFigure, 4> figures = {};

  /// The figure of a column; no value if the source has none.
  std::optional<double> value(std::string_view column) const noexcept;
};

/// The source of the rows of Anderson et al. They have no SPL, which was proposed afterwards.
inline constexpr std::string_view kFirstPaper = "Anderson et al., CVPR 2018, table 1";

/// All that is known to us with a source; no figure is from memory. Any thread.
std::span<const PublishedResult> published_results() noexcept;

/// The rows that may stand beside results of a split: of the same benchmark and split, and of as
/// many episodes where that is known. Not the shortest path, which uses the goal. None for
/// synthetic buildings, which no one else has measured.
std::vector<PublishedResult> published_beside(const Benchmark& benchmark, std::string_view split,
                                              std::size_t episodes, bool synthetic);

}  // namespace enfilade::tasks
