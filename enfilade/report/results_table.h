/// \file  The table of each benchmark: agents by splits, with intervals, beside what was published.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/report/run_directory.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/bootstrap.h"
#include "enfilade/tasks/goal.h"

namespace enfilade::report {

/// A column: a metric, and how it is shown.
struct TableColumn {
  std::string_view metric;  ///< its name in JSON and CSV: "success"
  std::string_view label;   ///< "SR (%)"
  double scale = 1;         ///< 100 for what is shown in per cent
  int digits = 2;           ///< after the point
  std::string_view scored =
      {};            ///< what Benchmark::table_scorer calls its mean; empty: RunScores::ours has it
  double least = 0;  ///< the smallest value that is possible
};
/// The columns of a benchmark's published tables, in their order. All of them have "success".
/// docs/report.md lists them, for example:
/// - R2R: TL NE SR OSR SPL
/// - REVERIE: SR OSR SPL RGS RGSPL
/// - continuous space: TL NE SR OSR SPL nDTW SDTW
std::span<const TableColumn> table_columns(const tasks::Benchmark& benchmark) noexcept;

/// A row of tasks::kFirstPaper, of R2R.
struct PublishedRow {
  std::size_t episodes = 0;      ///< of the paper's split: those of another number are other data
  double trajectory_length = 0;  ///< TL, metres
  double nav_error = 0;          ///< NE, metres
  double success = 0;            ///< SR, [0, 1]
  double oracle_success = 0;     ///< OSR, [0, 1]
};

/// The row of an agent, by its name in Enfilade. "student-forcing" is "student", and "-1" at the
/// end (a seed) is not part of the name. An ablation ("student-language") has no row.
std::optional<PublishedRow> published_row(std::string_view agent, std::string_view split) noexcept;

/// What a published row has in a column; none for SPL.
std::optional<double> published_value(const PublishedRow& row, std::string_view metric) noexcept;

/// One agent on one split.
struct TableRow {
  std::string agent;  ///< without its seeds: "student"
  std::string split;
  std::vector<std::string> runs;  ///< "student-1", "student-2"; at least one
  std::size_t episodes = 0;       ///< of the split, or of its language
  std::string language = {};      ///< of RxR's rows by language: "hi-IN"; empty: all
  /// By column, in the metric's own unit (metres, shares). One run has its mean and the bootstrap
  /// interval over paths. Several runs have the mean of their means and Student's interval over
  /// runs, clipped to the possible values. That interval shows how much runs differ by their seeds,
  /// not by the choice of paths.
  std::vector<tasks::MeanInterval> values;
  /// R2R: only if the episodes are those of the paper's split.
  std::optional<PublishedRow> published;
};

/// The table of a benchmark: rows of agents by split.
struct ResultsTable {
  const tasks::Benchmark* benchmark = &tasks::benchmark(tasks::Task::kR2r);
  std::span<const TableColumn> columns;
  bool synthetic = false;      ///< synthetic buildings: no published results beside them
  std::vector<TableRow> rows;  ///< by split (train, val_seen, val_unseen, others), then agent
  std::vector<std::string> left_out;  ///< as ScoredRuns::left_out
};

/// Rows of one agent's runs become one, with an interval over runs. Of RxR each is followed by rows
/// of its languages.
ResultsTable make_table(const ScoredRuns& runs, bool synthetic);

/// Mean and two-sided 95 % interval of a few independent samples by Student's distribution.
/// \pre not empty; of one sample the interval is empty (low = high = mean)
tasks::MeanInterval student_interval(std::span<const double> samples);

/// For people, in columns.
std::string to_text(const ResultsTable& table);
/// An object with these fields:
/// - "task" (its benchmark), "scorer", "source", "synthetic"
/// - "columns": [{"metric", "label", "scale", "digits"}]
/// - "notes"
/// - "rows": [{"agent", "split", "language"?, "runs", "episodes", "interval",
///   metric: {"mean", "low", "high", "published"?}}]
/// - "published": [{"agent", "source", metric: value}]
/// - "left_out"
///
/// Shares are in [0, 1]. What isn't finite is null. R4R and RxR have both `ndtw` and
/// `ndtw_collapsed`.
std::string to_json(const ResultsTable& table);
/// One line per row, as RFC 4180 has it. Columns: agent, split, language (RxR only), runs,
/// episodes, synthetic, then mean, low, high and published of each metric. Missing values are
/// empty, and shares are in [0, 1].
std::string to_csv(const ResultsTable& table);
/// A GitHub-flavoured table, for a README.
std::string to_markdown(const ResultsTable& table);

}  // namespace enfilade::report
