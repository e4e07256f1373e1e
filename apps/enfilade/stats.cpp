// enfilade stats: what a data set is like, in numbers.
#include <fmt/format.h>
#include <algorithm>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/task_option.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/statistics.h"

namespace enfilade::apps {
namespace stats_verb {
namespace {

struct Options {
  std::string data, task;
  std::vector<std::string> splits;
  std::string json;
  std::size_t top = 20;
};

tasks::Annotations load_split(const dataset::Dataset& data, tasks::Task task,
                              const std::string& split) {
  return task == tasks::Task::kR2r ? data.annotations(split) : data.annotations(task, split);
}

// What was asked for, or else those of the benchmark's public splits that the data set has.
std::vector<tasks::Annotations> load_splits(const Options& options, const dataset::Dataset& data,
                                            tasks::Task task) {
  const bool r2r = task == tasks::Task::kR2r;
  const auto there = [&](const std::string& split) {
    return r2r ? data.has_split(split) : data.has_split(task, split);
  };
  const bool named = !options.splits.empty();
  std::vector<tasks::Annotations> splits;
  std::vector<std::string> names = options.splits;
  if (!named && r2r) names.assign(dataset::kSplits.begin(), dataset::kSplits.end());
  if (!named && !r2r) names = data.splits(task);
  for (const std::string& split : names) {
    if (named || there(split)) {
      splits.push_back(load_split(data, task, split));
    } else {
      fmt::print(stderr, "note: {}: holds no R2R_{}.json\n", data.folder().string(), split);
    }
  }
  if (!splits.empty()) return splits;
  if (!r2r) data.annotations_file(task, tasks::benchmark(task).splits[2]);  // says what was tried
  throw FileError(
      fmt::format("{}: holds none of R2R_train.json, R2R_val_seen.json, "
                  "R2R_val_unseen.json, R2R_test.json; name others by --split",
                  data.folder().string()));
}

// Boxes tell who sees the objects of REVERIE's goals; the rest can be counted without.
const tasks::ObjectBoxes* objects_of(const dataset::Dataset& data, tasks::Task task,
                                     const std::vector<tasks::Annotations>& splits) {
  if (task != tasks::Task::kReverie) return nullptr;
  try {
    return &data.objects();
  } catch (const FileError& error) {
    if (std::ranges::none_of(splits, tasks::needs_boxes)) return nullptr;
    fmt::print(stderr, "note: who sees which object is not counted: {}\n", error.what());
    return nullptr;
  }
}

void stats(const Options& options) {
  const dataset::Dataset data = open_data(options.data);
  const tasks::Task task = task_of(options.task, data);
  const auto splits = load_splits(options, data, task);
  const auto statistics =
      tasks::compute_statistics(splits, data.graphs(), options.top, objects_of(data, task, splits));
  if (!options.json.empty()) write_output(options.json, to_json(statistics));
  if (options.json != "-") fmt::print("{}", to_table(statistics));
}

void add_verb(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "stats", "Print statistics of a data set: paths, instructions, goals, graphs");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_task_option(verb, options->task, "r2r, or what the data set has");
  add_value(verb, "--split", options->splits, "NAME",
            "Splits to count, one or more (default: those of train, val_seen, val_unseen and "
            "test that are there)");
  add_value(verb, "--json", options->json, "FILE",
            "Write the numbers as JSON; - for standard output, without the table");
  add_whole_number(verb, "--top", options->top,
                   "Number of most frequent openings (first four words) to list", 0);
  set_examples(verb,
               {"enfilade stats", "enfilade stats --split train val_seen --json stats.json",
                "enfilade stats --task reverie", "enfilade stats --json - | jq .all.vocabulary"});
  verb.callback([options] { stats(*options); });
}

}  // namespace
}  // namespace stats_verb

void add_stats(CLI::App& app, int& status) { stats_verb::add_verb(app, status); }

}  // namespace enfilade::apps
