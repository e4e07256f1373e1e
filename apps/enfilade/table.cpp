// enfilade table: the paper's table of everything that was run.
#include <filesystem>
#include <memory>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/task_option.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/report/results_table.h"

namespace enfilade::apps {
namespace table_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string data, task;
  std::vector<std::string> named;
  std::string output = "-";
  bool json = false, csv = false, markdown = false;
};

std::string formatted(const report::ResultsTable& table, const Options& options) {
  if (options.json) return to_json(table);
  if (options.csv) return to_csv(table);
  return options.markdown ? to_markdown(table) : to_text(table);
}

void table(const Options& options) {
  const dataset::Dataset data = open_data(options.data);
  const std::vector<fs::path> named(options.named.begin(), options.named.end());
  const tasks::Benchmark& benchmark = benchmark_of_runs(options.task, data, named);
  const report::RunDirectory found = report::find_runs(named, data, benchmark);
  const report::ResultsTable made =
      make_table(score_runs(found, data, progress_bar("scoring")), data.synthetic());
  if (made.rows.empty() && made.left_out.empty()) {
    throw UsageError("there are models here, but no results file; enfilade evaluate makes them");
  }
  write_output(options.output, formatted(made, options));
}

void add_verb(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("table",
                                       "Print a benchmark's table: agents by splits, with 95 % "
                                       "intervals");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_task_option(verb, options->task,
                  "what the results are of; where they say nothing, r2r or what the data set has",
                  FreeTasks::kToo);
  add_value(verb, "runs", options->named, "PATH",
            "Results files AGENT_SPLIT.json, model directories, or folders of them "
            "(docs/report.md)")
      ->required();
  add_setting(verb, "-o,--output", options->output, "FILE", "File; - for standard output");
  CLI::Option* json = verb.add_flag("--json", options->json, "As JSON");
  CLI::Option* csv = verb.add_flag("--csv", options->csv, "As CSV")->excludes(json);
  verb.add_flag("--markdown", options->markdown, "As a Markdown table")
      ->excludes(json)
      ->excludes(csv);
  set_examples(verb, {"enfilade table enfilade-demo --data enfilade-demo/homes",
                      "enfilade table random_val_seen.json models/student-1 models/student-2",
                      "enfilade table enfilade-demo --csv -o table.csv",
                      "enfilade table walks --task r2r-ce --data homes",
                      "enfilade table runs/reverie --task reverie --markdown"});
  verb.callback([options] { table(*options); });
}

}  // namespace
}  // namespace table_verb

void add_table(CLI::App& app, int& status) { table_verb::add_verb(app, status); }

}  // namespace enfilade::apps
