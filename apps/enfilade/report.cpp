// enfilade report: everything about a run on one HTML page; enfilade table: the paper's table of
// everything that was run.
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <ctime>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/task_option.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/threads.h"
#include "enfilade/report/report.h"
#include "enfilade/report/results_table.h"
#include "enfilade/report/run_directory.h"

namespace enfilade::apps {
namespace {

// Which results a verb is about.
struct RunsOptions {
  std::string data, task, output;
  std::vector<std::string> named;
};

void add_source_options(CLI::App& verb, RunsOptions& options) {
  add_data_option(verb, options.data);
  add_task_option(verb, options.task,
                  "what the results are of; where they say nothing, r2r or what the data set has",
                  Worlds::kBoth);
}

// The benchmark of some results, in either world. The option's, if it names one. Else the one that
// the results show; if they show none, as benchmark_of().
const tasks::Benchmark& benchmark_of_runs(const std::string& named, const dataset::Dataset& data,
                                          std::span<const std::filesystem::path> results) {
  return benchmark_of(named, data,
                      named.empty() ? report::find_benchmark_of_runs(results) : nullptr);
}

}  // namespace

namespace report_verb {
namespace {

struct Options : RunsOptions {
  report::ReportConfig config;
};

void make(const Options& options) {
  const dataset::Dataset data = open_data(options.data);
  report::ReportConfig config = options.config;
  config.runs.assign(options.named.begin(), options.named.end());
  config.benchmark = &benchmark_of_runs(options.task, data, config.runs);
  config.facts = {
      {"Enfilade", version_with_commit()},
      {"made on", fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)))},
      {"made with", fmt::format("{}, {} cores", processor_name(), available_threads())}};
  const std::string page = make_report(config, data, progress_bar("report"));
  write_output(options.output, page);
  if (options.output == "-") return;
  say("{}: {:.1f} MB, one file, to be opened in any browser\n", options.output,
      static_cast<double>(page.size()) / 1e6);
}

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "report", "Write one HTML page of a run: results, curves, episodes, data");
  const auto options = std::make_shared<Options>();
  options->output = "report.html";
  add_source_options(verb, *options);
  add_value(verb, "runs", options->named, "PATH",
            "Folder of a run, model directories, results files AGENT_SPLIT.json")
      ->required();
  add_setting(verb, "-o,--output", options->output, "FILE", "File; - for standard output");
  add_setting(verb, "--title", options->config.title, "TEXT", "Title of the page");
  add_whole_number(verb, "--episodes", options->config.episodes_of_a_kind,
                   "Episodes of each kind: best, worst, at random", 0)
      ->type_name("N");
  add_whole_number(verb, "--panoramas", options->config.panoramas,
                   "Largest number of buildings shown", 0)
      ->type_name("N");
  set_examples(verb, {"enfilade report enfilade-demo --data enfilade-demo/homes -o report.html",
                      "enfilade report models/student-1 random_val_unseen.json --episodes 5"});
  verb.callback([options] { make(*options); });
}

}  // namespace report_verb

namespace table_verb {
namespace {

namespace fs = std::filesystem;

struct Options : RunsOptions {
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

}  // namespace

void add(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "table", "Print a benchmark's table: agents by splits, with 95 % intervals");
  const auto options = std::make_shared<Options>();
  options->output = "-";
  add_source_options(verb, *options);
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

}  // namespace table_verb

}  // namespace enfilade::apps
