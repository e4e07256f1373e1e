#include "enfilade/report/results_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/core/check.h"

namespace enfilade::report {
namespace {

constexpr std::array<TableColumn, kTableColumns> kColumns{{
    {"trajectory_length", "TL (m)", 1, 2},
    {"nav_error", "NE (m)", 1, 2},
    {"success", "SR (%)", 100, 1},
    {"oracle_success", "OSR (%)", 100, 1},
    {"spl", "SPL (%)", 100, 1},
}};

constexpr std::array<PublishedRow, 11> kPublished{{
    {"shortest", "val_seen", 10.19, 0, 1, 1},
    {"random", "val_seen", 9.58, 9.45, 0.159, 0.214},
    {"teacher", "val_seen", 10.95, 8.01, 0.271, 0.367},
    {"student", "val_seen", 11.33, 6.01, 0.386, 0.529},
    {"shortest", "val_unseen", 9.48, 0, 1, 1},
    {"random", "val_unseen", 9.77, 9.23, 0.163, 0.220},
    {"teacher", "val_unseen", 10.67, 8.61, 0.196, 0.291},
    {"student", "val_unseen", 8.39, 7.81, 0.218, 0.284},
    {"random", "test", 9.93, 9.77, 0.132, 0.183},
    {"student", "test", 8.13, 7.85, 0.204, 0.266},
    {"human", "test", 11.90, 1.61, 0.864, 0.902},
}};

std::size_t split_rank(const std::string& split) {
  constexpr std::array<std::string_view, 4> kOrder{"train", "val_seen", "val_unseen", "test"};
  return static_cast<std::size_t>(std::ranges::find(kOrder, split) - kOrder.begin());
}

// Quantile 0.975 of Student's distribution with this many degrees of freedom (from a printed
// table).
double student_quantile(std::size_t freedom) {
  constexpr std::array<double, 30> kTable{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306,
                                          2.262,  2.228, 2.201, 2.179, 2.160, 2.145, 2.131, 2.120,
                                          2.110,  2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064,
                                          2.060,  2.056, 2.052, 2.048, 2.045, 2.042};
  if (freedom <= kTable.size()) return kTable.at(freedom - 1);
  return 1.960 + 2.45 / static_cast<double>(freedom);  // within 0.001 of the table's next entries
}

tasks::MeanInterval value_of(const std::vector<const ScoredRun*>& runs, const TableColumn& column) {
  if (runs.size() == 1) return runs.front()->score.mean(column.metric);
  std::vector<double> means;
  for (const ScoredRun* run : runs) means.push_back(run->score.mean(column.metric).mean);
  tasks::MeanInterval interval = student_interval(means);
  interval.low = std::max(interval.low, 0.0);
  if (column.scale != 1) interval.high = std::min(interval.high, 1.0);
  return interval;
}

TableRow make_row(const std::vector<const ScoredRun*>& runs, bool synthetic) {
  const ScoredRun& first = *runs.front();
  TableRow row;
  row.agent = without_seed(first.agent);
  row.split = first.split;
  for (const ScoredRun* run : runs) row.runs.push_back(run->agent);
  row.episodes = first.score.episodes.size();
  for (std::size_t k = 0; k < kTableColumns; ++k) row.values[k] = value_of(runs, kColumns[k]);
  if (!synthetic && row.episodes == published_episodes(row.split)) {
    row.published = published_row(row.agent, row.split);
  }
  return row;
}

}  // namespace

std::span<const TableColumn, kTableColumns> table_columns() noexcept { return kColumns; }

tasks::MeanInterval student_interval(std::span<const double> samples) {
  EN_CHECK(!samples.empty());
  const auto n = static_cast<double>(samples.size());
  double mean = 0;
  for (const double x : samples) mean += x / n;
  if (samples.size() == 1 || !std::isfinite(mean)) return {mean, mean, mean};
  double squares = 0;
  for (const double x : samples) squares += (x - mean) * (x - mean);
  const double half = student_quantile(samples.size() - 1) * std::sqrt(squares / (n - 1) / n);
  return {mean, mean - half, mean + half};
}

ResultsTable make_table(const ScoredRuns& runs, bool synthetic) {
  // Runs are sorted by agent; the rows of a split keep that order.
  std::vector<std::vector<const ScoredRun*>> groups;
  for (const ScoredRun& run : runs.runs) {
    const auto same = std::ranges::find_if(groups, [&run](const auto& group) {
      return group.front()->split == run.split &&
             without_seed(group.front()->agent) == without_seed(run.agent);
    });
    if (same == groups.end()) {
      groups.push_back({&run});
    } else {
      same->push_back(&run);
    }
  }
  std::ranges::stable_sort(groups, [](const auto& a, const auto& b) {
    const std::string &x = a.front()->split, &y = b.front()->split;
    return std::pair(split_rank(x), x) < std::pair(split_rank(y), y);
  });
  ResultsTable table{synthetic, {}, runs.left_out};
  for (const auto& group : groups) table.rows.push_back(make_row(group, synthetic));
  return table;
}

std::optional<PublishedRow> published_row(std::string_view agent, std::string_view split) noexcept {
  constexpr std::string_view kForcing = "-forcing";
  std::string_view name = without_seed(agent);
  if (name.ends_with(kForcing)) name.remove_suffix(kForcing.size());
  const auto row = std::ranges::find_if(
      kPublished, [&](const PublishedRow& r) { return r.agent == name && r.split == split; });
  return row == kPublished.end() ? std::nullopt : std::optional(*row);
}

std::size_t published_episodes(std::string_view split) noexcept {
  if (split == "val_seen") return 1020;
  if (split == "val_unseen") return 2349;
  return split == "test" ? 4173 : 0;
}

std::optional<double> published_value(const PublishedRow& row, std::string_view metric) noexcept {
  if (metric == "trajectory_length") return row.trajectory_length;
  if (metric == "nav_error") return row.nav_error;
  if (metric == "success") return row.success;
  if (metric == "oracle_success") return row.oracle_success;
  return std::nullopt;
}

}  // namespace enfilade::report
