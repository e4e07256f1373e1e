// enfilade stats: what a data set is like, in numbers.
#include <fmt/format.h>
#include <algorithm>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/task_option.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/statistics.h"

namespace enfilade::apps::stats_verb {
namespace {

struct Options {
  std::string data, task, json;
  std::vector<std::string> splits;
  std::size_t top = 20;
};

// What was asked for, or else those of the benchmark's public splits that the data set has.
std::vector<tasks::Annotations> load_splits(const Options& options, const dataset::Dataset& data,
                                            const tasks::Benchmark& benchmark) {
  const std::vector<std::string> names =
      options.splits.empty() ? data.splits(benchmark) : options.splits;
  if (names.empty()) data.episodes_file(benchmark, benchmark.splits[2]);  // says what was tried
  for (const std::string_view usual : benchmark.splits) {
    if (!options.splits.empty() || data.has_split(benchmark, usual)) continue;
    if (!benchmark.in_paper) continue;  // nobody has all splits of the others
    say(stderr, "note: {}: has no split {} of {}\n", data.folder().string(), usual,
        benchmark.title);
  }
  std::vector<tasks::Annotations> splits;
  for (const std::string& split : names) {
    splits.push_back(data.annotations(benchmark.task, split));
  }
  return splits;
}

// Boxes tell who sees the objects of REVERIE's goals; the rest can be counted without.
const tasks::ObjectBoxes* objects_of(const dataset::Dataset& data, tasks::Task task,
                                     const std::vector<tasks::Annotations>& splits) {
  if (task != tasks::Task::kReverie) return nullptr;
  try {
    return &data.objects();
  } catch (const FileError& error) {
    if (std::ranges::none_of(splits, tasks::needs_boxes)) return nullptr;
    say(stderr, "note: who sees which object is not counted: {}\n", error.what());
    return nullptr;
  }
}

void stats(const Options& options) {
  const dataset::Dataset data = open_data(options.data);
  const tasks::Task task = task_of(options.task, data);
  const auto splits = load_splits(options, data, tasks::benchmark(task));
  const auto statistics =
      tasks::compute_statistics(splits, data.graphs(), options.top, objects_of(data, task, splits));
  if (!options.json.empty()) write_output(options.json, to_json(statistics));
  if (options.json != "-") say("{}", to_table(statistics));
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
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

}  // namespace enfilade::apps::stats_verb
