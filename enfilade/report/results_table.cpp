#include "enfilade/report/results_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/published.h"
#include "enfilade/tasks/scorer.h"

namespace enfilade::report {
namespace {

// What the paper calls our agents.
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kPapersNames{
    {{"shortest", "Shortest"},
     {"random", "Random"},
     {"teacher", "Seq2Seq, teacher forcing"},
     {"student", "Seq2Seq, student forcing"},
     {"human", "Human"}}};

std::size_t split_rank(const std::string& split) {
  constexpr std::array<std::string_view, 7> kOrder{
      "train", "val_seen", "val_seen_instrs", "val_unseen", "val_unseen_instrs", "val_unseen_house",
      "test"};
  return static_cast<std::size_t>(std::ranges::find(kOrder, split) - kOrder.begin());
}

// Quantile 0.975 of Student's distribution, from a printed table.
double student_quantile(std::size_t freedom) {
  constexpr std::array<double, 30> kTable{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306,
                                          2.262,  2.228, 2.201, 2.179, 2.160, 2.145, 2.131, 2.120,
                                          2.110,  2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064,
                                          2.060,  2.056, 2.052, 2.048, 2.045, 2.042};
  if (freedom <= kTable.size()) return kTable.at(freedom - 1);
  return 1.960 + 2.45 / static_cast<double>(freedom);  // within 0.001 of the table's next entries
}

// Of one run; shares in [0, 1], whatever the scorer prints.
tasks::MeanInterval value_of(const RunScores& scores, const TableColumn& column) {
  const tasks::ScoreTable& score = column.scored.empty() ? scores.ours : *scores.by_task;
  const std::string_view name = column.scored.empty() ? column.metric : column.scored;
  const tasks::MeanInterval mean = score.mean(name);
  const double scale = score.scorer->metrics[score.scorer->place_of(name)].scale;
  return {mean.mean / scale, mean.low / scale, mean.high / scale};
}

// Several runs: the mean of their means, with Student's interval.
tasks::MeanInterval value_over(const std::vector<const RunScores*>& runs,
                               const TableColumn& column) {
  if (runs.size() == 1) return value_of(*runs.front(), column);
  std::vector<double> means;
  for (const RunScores* run : runs) means.push_back(value_of(*run, column).mean);
  tasks::MeanInterval interval = student_interval(means);
  interval.low = std::max(interval.low, column.least);
  if (column.scale != 1) interval.high = std::min(interval.high, 1.0);
  return interval;
}

// A row of a language, or of all where it is empty.
TableRow make_row(const std::vector<const ScoredRun*>& runs, std::span<const TableColumn> columns,
                  const std::string& language) {
  TableRow row;
  row.agent = without_seed(runs.front()->agent);
  row.split = runs.front()->split;
  row.language = language;
  std::vector<const RunScores*> scores;
  for (const ScoredRun* run : runs) {
    row.runs.push_back(run->agent);
    scores.push_back(language.empty() ? &run->scores : &run->languages.at(language));
  }
  row.episodes = scores.front()->ours.episodes;
  for (const TableColumn& column : columns) row.values.push_back(value_over(scores, column));
  return row;
}

// Runs of one agent and split, by split; a split's rows keep the order of agents.
std::vector<std::vector<const ScoredRun*>> groups_of(const std::vector<ScoredRun>& runs) {
  std::vector<std::vector<const ScoredRun*>> groups;
  for (const ScoredRun& run : runs) {
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
  return groups;
}

}  // namespace

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
  ResultsTable table;
  table.benchmark = runs.benchmark;
  table.columns = table_columns(*runs.benchmark);
  table.synthetic = synthetic;
  table.left_out = runs.left_out;
  const bool papers = table.benchmark->in_paper && !table.synthetic;
  for (const auto& group : groups_of(runs.runs)) {
    TableRow& row = table.rows.emplace_back(make_row(group, table.columns, {}));
    if (papers) row.published = published_row(row.agent, row.split);
    if (row.published && row.published->episodes != row.episodes) row.published.reset();
    for (const auto& [language, scores] : group.front()->languages) {
      table.rows.push_back(make_row(group, table.columns, language));
    }
  }
  return table;
}

std::optional<PublishedRow> published_row(std::string_view agent, std::string_view split) noexcept {
  constexpr std::string_view kForcing = "-forcing";
  std::string_view name = without_seed(agent);
  if (name.ends_with(kForcing)) name.remove_suffix(kForcing.size());
  const auto known =
      std::ranges::find(kPapersNames, name, [](const auto& one) { return one.first; });
  if (known == kPapersNames.end()) return std::nullopt;
  const auto all = tasks::published_results();
  const auto row = std::ranges::find_if(all, [&](const tasks::PublishedResult& one) {
    return one.source == tasks::kFirstPaper && one.agent == known->second && one.split == split;
  });
  if (row == all.end()) return std::nullopt;
  return PublishedRow{row->episodes, row->value("TL").value(), row->value("NE").value(),
                      row->value("SR").value(), row->value("OSR").value()};
}

std::optional<double> published_value(const PublishedRow& row, std::string_view metric) noexcept {
  if (metric == "trajectory_length") return row.trajectory_length;
  if (metric == "nav_error") return row.nav_error;
  if (metric == "success") return row.success;
  if (metric == "oracle_success") return row.oracle_success;
  return std::nullopt;
}

}  // namespace enfilade::report
