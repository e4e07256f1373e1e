// The agents on a set of model homes with every benchmark, from the files to the table. SYNTHETIC.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/agents/run.h"
#include "enfilade/core/file.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/report/results_table.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/statistics.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

namespace fs = std::filesystem;
using tasks::Task;

constexpr std::array kTasks{Task::kR2r, Task::kR2rLast, Task::kR2rBack, Task::kR4r,
                            Task::kRxr, Task::kReverie, Task::kCvdn,    Task::kSoon};

// Made once; the tests only read it.
const fs::path& folder() {
  static const TemporaryFolder kFolder("agents-on-homes");
  static const bool kMade = [] {
    homes::HomeSetOptions options = homes::home_set_preset("graphs");
    options.homes = 4;
    homes::write_homes(kFolder.path(), options);
    homes::write_home_paths(kFolder.path(), {.per_home = 30});
    return true;
  }();
  EXPECT_TRUE(kMade);
  return kFolder.path();
}

// The splits of a benchmark whose goals are known, training aside.
std::vector<std::string> known_splits(const dataset::Dataset& data, Task task) {
  std::vector<std::string> splits = data.splits(tasks::benchmark(task));
  std::erase_if(splits, [](const std::string& split) { return !split.starts_with("val"); });
  return splits;
}

tasks::EpisodeSet episodes_of(const dataset::Dataset& data, Task task, const std::string& split) {
  return data.episodes(task, split);
}

// The table of three agents on all such splits: results are written, found, read and scored.
report::ResultsTable table_of(Task task) {
  const dataset::Dataset data(folder());
  const TemporaryFolder runs(fmt::format("runs-{}", tasks::benchmark(task).name));
  for (const std::string& split : known_splits(data, task)) {
    const tasks::EpisodeSet episodes = episodes_of(data, task, split);
    for (const char* name : {"shortest", "random", "reference"}) {
      const auto trajectories = agents::run_agent(*agents::make_agent(name), episodes);
      write_file_atomically(runs.path() / fmt::format("{}_{}.json", name, split),
                            to_json(trajectories, episodes));
    }
  }
  const std::vector<fs::path> named{runs.path()};
  return report::make_table(
      report::score_runs(report::find_runs(named, data, tasks::benchmark(task)), data),
      data.synthetic());
}

// The value of a metric in a row; nothing if the table has no such column.
std::optional<double> value(const report::ResultsTable& table, const report::TableRow& row,
                            std::string_view metric) {
  const auto columns = table.columns;
  const auto column = std::ranges::find(columns, metric, &report::TableColumn::metric);
  if (column == columns.end()) return std::nullopt;
  return row.values.at(static_cast<std::size_t>(column - columns.begin())).mean;
}

class EveryTask : public ::testing::TestWithParam<Task> {};

TEST_P(EveryTask, ShortestAlwaysArrivesAndRandomSeldom) {
  const report::ResultsTable table = table_of(GetParam());
  EXPECT_TRUE(table.synthetic);
  ASSERT_FALSE(table.rows.empty()) << tasks::benchmark(GetParam()).name;
  fmt::print("{}\n", to_markdown(table));
  for (const report::TableRow& row : table.rows) {
    const double success = value(table, row, "success").value();
    const auto named = value(table, row, "rgs");
    if (row.agent == "shortest") {
      EXPECT_EQ(success, 1) << row.split << " " << row.language;
      if (named) {
        EXPECT_EQ(*named, 1) << row.split;
      }
    } else if (row.agent == "random") {
      EXPECT_LT(success, 0.6) << row.split << " " << row.language;
      if (named) {
        EXPECT_LT(*named, 0.5) << row.split;
      }
    }
  }
}

TEST_P(EveryTask, StatisticsCountWhatItHas) {
  const dataset::Dataset data(folder());
  const Task task = GetParam();
  std::vector<tasks::Annotations> splits;
  for (const std::string& split : data.splits(tasks::benchmark(task))) {
    splits.push_back(data.annotations(task, split));
  }
  const auto* objects = task == Task::kReverie ? &data.objects() : nullptr;
  const auto statistics = compute_statistics(splits, data.graphs(), 5, objects);
  const tasks::TaskFacts& facts = statistics.all.task;
  EXPECT_GT(statistics.all.instructions, 0U);
  if (task == Task::kReverie) {
    EXPECT_GT(facts.objects, 0U);
    EXPECT_GE(facts.goal_viewpoints.min, 1);
  }
  if (task == Task::kCvdn) {
    EXPECT_GT(facts.turns.max, 0);
  }
  if (task == Task::kSoon) {
    EXPECT_GT(facts.boxes, 0U);
  }
  if (task == Task::kRxr) {
    EXPECT_FALSE(facts.languages.empty());
  }
  EXPECT_NE(to_table(statistics).find("vocabulary"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Homes, EveryTask, ::testing::ValuesIn(kTasks), [](const auto& task) {
  std::string name(tasks::benchmark(task.param).name);
  std::ranges::replace(name, '-', '_');
  return name;
});

}  // namespace EN_UNIT
}  // namespace enfilade::tests
