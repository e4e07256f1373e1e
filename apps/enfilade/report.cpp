// enfilade report: everything about a run on one HTML page.
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <ctime>
#include <memory>
#include <string_view>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/task_option.h"
#include "apps/enfilade/verbs.h"
#include "apps/enfilade/version.h"
#include "enfilade/core/threads.h"
#include "enfilade/report/report.h"
#include "enfilade/report/run_directory.h"

namespace enfilade::apps {
namespace report_verb {
namespace {

struct Options {
  std::string data, task;
  std::vector<std::string> named;
  std::string output = "report.html";
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
  fmt::print("{}: {:.1f} MB, one file, to be opened in any browser\n", options.output,
             static_cast<double>(page.size()) / 1e6);
}

void add_verb(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand(
      "report", "Write one HTML page of a run: results, curves, episodes, data");
  const auto options = std::make_shared<Options>();
  add_data_option(verb, options->data);
  add_task_option(verb, options->task,
                  "what the results are of; where they say nothing, r2r or what the data set has",
                  FreeTasks::kToo);
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

}  // namespace
}  // namespace report_verb

void add_report(CLI::App& app, int& status) { report_verb::add_verb(app, status); }

}  // namespace enfilade::apps
