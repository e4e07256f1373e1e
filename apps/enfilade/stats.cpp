// enfilade stats: what a data set is like, in numbers.
#include <fmt/format.h>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/tasks/statistics.h"

namespace enfilade::apps {
namespace {

struct Options {
  std::string data;
  std::vector<std::string> splits;
  std::string json;
  std::size_t top = 20;
};

// What was asked for, or else those of R2R's four splits that the data set has.
std::vector<tasks::Annotations> load_splits(const Options& options, const dataset::Dataset& data) {
  const bool named = !options.splits.empty();
  std::vector<tasks::Annotations> splits;
  std::vector<std::string> names = options.splits;
  if (!named) names.assign(dataset::kSplits.begin(), dataset::kSplits.end());
  for (const std::string& split : names) {
    if (named || data.has_split(split)) {
      splits.push_back(data.annotations(split));
    } else {
      fmt::print(stderr, "note: {}: holds no R2R_{}.json\n", data.folder().string(), split);
    }
  }
  if (splits.empty()) {
    throw FileError(
        fmt::format("{}: holds none of R2R_train.json, R2R_val_seen.json, "
                    "R2R_val_unseen.json, R2R_test.json; name others by --split",
                    data.folder().string()));
  }
  return splits;
}

void stats(const Options& options) {
  const dataset::Dataset data = open_data(options.data);
  const auto statistics =
      tasks::compute_statistics(load_splits(options, data), data.graphs(), options.top);
  if (!options.json.empty()) write_output(options.json, to_json(statistics));
  if (options.json != "-") fmt::print("{}", to_table(statistics));
}

}  // namespace

void add_stats(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "stats", "What a data set is like: paths, instructions, vocabulary, graphs");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_value(verb, "--split", options->splits, "NAME",
            "Splits to count, one or more (default: those of train, val_seen, val_unseen and "
            "test that are there)");
  add_value(verb, "--json", options->json, "FILE",
            "Write the numbers as JSON; - for standard output, without the table");
  add_whole_number(verb, "--top", options->top,
                   "How many of the most frequent first four words to list", 0);
  set_examples(verb, {"enfilade stats", "enfilade stats --split train val_seen --json stats.json",
                      "enfilade stats --json - | jq .all.vocabulary"});
  verb.callback([options] { stats(*options); });
}

}  // namespace enfilade::apps
