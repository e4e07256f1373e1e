/// \file  The paper's table: agents by splits, with intervals, beside what was published.
#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/report/scored_runs.h"
#include "enfilade/tasks/bootstrap.h"

namespace enfilade::report {

/// A column: a metric of r2r/metrics.h, and how it is shown.
struct TableColumn {
  std::string_view metric;  ///< "success"
  std::string_view label;   ///< "SR (%)"
  double scale = 1;         ///< 100 for what is shown in per cent
  int digits = 2;           ///< after the point
};
/// How many metrics the paper's table has.
inline constexpr std::size_t kTableColumns = 5;
std::span<const TableColumn, kTableColumns> table_columns() noexcept;  ///< TL NE SR OSR SPL

/// A row of table 1 of Anderson et al., CVPR 2018. The paper has no SPL, which its authors proposed
/// afterwards.
struct PublishedRow {
  std::string_view agent;        ///< "shortest", "random", "teacher", "student", "human"
  std::string_view split;        ///< "val_seen", "val_unseen", "test"
  double trajectory_length = 0;  ///< TL, metres
  double nav_error = 0;          ///< NE, metres
  double success = 0;            ///< SR, [0, 1]
  double oracle_success = 0;     ///< OSR, [0, 1]
};

/// The row of an agent by the name that it has here; "student-forcing" is "student", "-1" at the
/// end (a seed) is not part of the name. An ablation ("student-language") has no row.
std::optional<PublishedRow> published_row(std::string_view agent, std::string_view split) noexcept;

/// How many instructions the paper's split has; 0 for one that it does not have. Figures of another
/// number of episodes are of another data set, and no published row belongs beside them.
std::size_t published_episodes(std::string_view split) noexcept;

/// What a published row has in a column; none for SPL.
std::optional<double> published_value(const PublishedRow& row, std::string_view metric) noexcept;

/// One agent on one split.
struct TableRow {
  std::string agent;  ///< without its seeds: "student"
  std::string split;
  std::vector<std::string> runs;  ///< "student-1", "student-2"; at least one
  std::size_t episodes = 0;       ///< of the split
  /// By column, in the metric's own unit (metres, shares). Of one run: its mean and the bootstrap
  /// interval over paths. Of several: the mean of their means and Student's interval of it over
  /// runs, clipped to the values that are possible. It shows how much runs differ by their seeds,
  /// not by the choice of paths.
  std::array<tasks::MeanInterval, kTableColumns> values;
  std::optional<PublishedRow> published;  ///< only where episodes are those of the paper's split
};

/// The paper's table: rows of agents by split.
struct ResultsTable {
  bool synthetic = false;      ///< of made-up buildings: nothing published belongs beside them
  std::vector<TableRow> rows;  ///< by split (train, val_seen, val_unseen, others), then agent
  std::vector<std::string> left_out;  ///< as ScoredRuns::left_out
};

/// Rows of one agent's runs become one, with an interval over runs.
ResultsTable make_table(const ScoredRuns& runs, bool synthetic);

/// Mean and two-sided 95 % interval of a few independent samples by Student's distribution.
/// \pre not empty; of one sample the interval is empty (low = high = mean)
tasks::MeanInterval student_interval(std::span<const double> samples);

/// For people, in columns.
std::string to_text(const ResultsTable& table);
/// {"synthetic", "rows": [{"agent", "split", "runs", "episodes", "interval", metric: {"mean",
/// "low", "high", "published"?}}], "left_out"}; shares in [0, 1]. What isn't finite is null.
std::string to_json(const ResultsTable& table);
/// A line for each row, as RFC 4180 has it: agent, split, runs, episodes, synthetic, then mean,
/// low, high and published of each metric (empty where there is none); shares in [0, 1].
std::string to_csv(const ResultsTable& table);
/// A GitHub-flavoured table, for a README.
std::string to_markdown(const ResultsTable& table);

}  // namespace enfilade::report
