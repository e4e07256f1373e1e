// check_vectors: compares golden vectors of metrics, of navigable viewpoints and of public scorers
// with what we compute.
#include <fmt/format.h>
#include <memory>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "tests/conformance/benchmarks.h"
#include "tests/conformance/data_beside.h"
#include "tests/conformance/doubtful.h"
#include "tests/conformance/vectors.h"

namespace enfilade::tests {
namespace {

using namespace apps;

struct Options {
  std::vector<std::string> files;
  std::string data;
  VectorTolerances tolerances;
  bool doubtful = false;
};

VectorReport check_file(const std::string& file, const Options& options) {
  if (!is_benchmark_file(file)) {
    const auto graphs = open_data_beside(options.data, file).graphs();
    return check_vectors(file, graphs, options.tolerances);
  }
  // Their folder is one deeper than that of other vectors.
  const auto data = open_data_beside(options.data, std::filesystem::absolute(file).parent_path());
  return check_benchmark(file, data.folder(), data.graphs(), options.tolerances);
}

// As a table of Markdown.
void print_doubtful(const std::string& file, const Options& options) {
  const auto data = open_data_beside(options.data, std::filesystem::absolute(file).parent_path());
  fmt::print("\n{}\n\n| input | scorer | it gives | ours |\n|---|---|---|---|\n", file);
  for (const DoubtfulInput& row : doubtful_inputs(file, data.folder(), data.graphs())) {
    fmt::print("| {} | `{}` | {} | {} |\n", row.input, row.scorer, row.theirs, row.ours);
  }
}

ExitCode check(const Options& options) {
  if (options.doubtful) {
    for (const std::string& file : options.files) print_doubtful(file, options);
    return kSuccess;
  }
  VectorReport total;
  for (const std::string& file : options.files) {
    const VectorReport report = check_file(file, options);
    for (const std::string& line : report.examples) fmt::print("{}: {}\n", file, line);
    if (report.mismatches > report.examples.size()) {
      fmt::print("{}: ... and {} more\n", file, report.mismatches - report.examples.size());
    }
    fmt::print("{}: {} cases, {} mismatches\n", file, report.cases, report.mismatches);
    total.cases += report.cases;
    total.mismatches += report.mismatches;
  }
  fmt::print("{} cases, {} mismatches\n", total.cases, total.mismatches);
  return total.mismatches > 0 ? kFaultsFound : kSuccess;
}

}  // namespace
}  // namespace enfilade::tests

int main(int argc, char** argv) {
  using namespace enfilade::tests;
  CLI::App app(
      "Compares golden vectors of metrics, navigable viewpoints and public scorers with ours.",
      "check_vectors");
  Options options;
  int status = kSuccess;
  app.add_option("files", options.files,
                 "metrics_*.json, nav_*.json, or recorded scores of a benchmark")
      ->required()
      ->type_name("FILE.json");
  app.add_option("--data", options.data,
                 "Data set: a folder with connectivity/ (default: ENFILADE_DATA, else ../data "
                 "beside the file's folder)")
      ->type_name("DIR");
  app.add_flag("--doubtful", options.doubtful,
               "Of recorded scores of a benchmark: print what ours does with doubtful inputs");
  app.add_option("--tolerance-metrics", options.tolerances.metrics,
                 "Largest difference of a metric")
      ->capture_default_str()
      ->check(finite_number());
  app.add_option("--tolerance-nav", options.tolerances.nav,
                 "Largest difference of an angle (rad) or distance (m)")
      ->capture_default_str()
      ->check(finite_number());
  app.footer(
      "Exit codes: 0 all agree, 1 mismatches, 2 command line, 3 a file that cannot be used.");
  app.callback([&] { status = check(options); });
  return run_program(app, argc, argv, status);
}
