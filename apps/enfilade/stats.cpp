// enfilade stats: what a data set is like, in numbers.
#include <fmt/format.h>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/r2r/statistics.h"

namespace enfilade::apps {
namespace {

struct Options {
  std::string data;
  std::vector<std::string> splits;
  std::string json;
  std::size_t top = 20;
};

// What was asked for, or else those of R2R's four splits that the data set has.
std::vector<r2r::Annotations> load_splits(const Options& options, const scan::DataRoot& data) {
  std::vector<r2r::Annotations> splits;
  if (!options.splits.empty()) {
    for (const std::string& split : options.splits) {
      splits.push_back(r2r::load_annotations(data.annotations(split), split));
    }
    return splits;
  }
  std::string missing;
  for (const char* split : {"train", "val_seen", "val_unseen", "test"}) {
    std::filesystem::path file;
    try {
      file = data.annotations(split);
    } catch (const FileError& error) {
      missing += fmt::format("note: {}\n", error.what());
      continue;
    }
    splits.push_back(r2r::load_annotations(file, split));
  }
  if (splits.empty()) {
    throw FileError(
        fmt::format("{}: holds none of R2R_train.json, R2R_val_seen.json, "
                    "R2R_val_unseen.json, R2R_test.json; name others by --split",
                    data.folder().string()));
  }
  fmt::print(stderr, "{}", missing);
  return splits;
}

void stats(const Options& options) {
  const scan::DataRoot data = open_data(options.data);
  const auto splits = load_splits(options, data);
  const auto statistics =
      r2r::compute_statistics(splits, graph::GraphSet::open(data.connectivity()), options.top);
  if (!options.json.empty()) write_output(options.json, to_json(statistics));
  if (options.json != "-") fmt::print("{}", to_table(statistics));
}

}  // namespace

void add_stats(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand(
      "stats", "What a data set is like: paths, instructions, vocabulary, graphs");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  verb.add_option("--split", options->splits,
                  "Splits to count, one or more (default: those of train, val_seen, val_unseen and "
                  "test that are there)")
      ->type_name("NAME");
  verb.add_option("--json", options->json,
                  "Write the numbers as JSON; - for standard output, without the table")
      ->type_name("FILE");
  verb.add_option("--top", options->top, "How many of the most frequent first four words to list")
      ->check(whole_number())
      ->capture_default_str();
  set_examples(verb, {"enfilade stats", "enfilade stats --split train val_seen --json stats.json",
                      "enfilade stats --json - | jq .all.vocabulary"});
  verb.callback([options, &status] {
    stats(*options);
    status = kSuccess;
  });
}

}  // namespace enfilade::apps
