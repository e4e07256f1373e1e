// check_vectors: compares golden vectors of metrics, of navigable viewpoints and of public scorers
// with what we compute.
#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "apps/common/program.h"
#include "enfilade/core/file.h"
#include "enfilade/tasks/benchmark.h"
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
  std::string page;
  bool write_page = false;
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

bool is_continuous(const std::string& file) {
  return std::filesystem::path(file).stem() == "vlnce";
}

// "r2r_back.json" has what was recorded of R2R-Back.
std::string_view title_of(const std::string& file) {
  if (is_continuous(file)) return "VLN-CE";
  std::string name = std::filesystem::path(file).stem().string();
  std::ranges::replace(name, '_', '-');
  return tasks::benchmark(name).title;
}

// As a table of Markdown.
std::string doubtful_table(const std::string& file, const Options& options) {
  const auto data = open_data_beside(options.data, std::filesystem::absolute(file).parent_path());
  std::string table = fmt::format(
      "\n## {}\n\n| input | scorer | it gives | ours |\n|---|---|---|---|\n", title_of(file));
  for (const DoubtfulInput& row : is_continuous(file)
                                      ? doubtful_walks(file, data.folder())
                                      : doubtful_inputs(file, data.folder(), data.graphs())) {
    table += fmt::format("| {} | `{}` | {} | {} |\n", row.input, row.scorer, row.theirs, row.ours);
  }
  return table;
}

// The page that says so of all files.
std::string doubtful_page(const Options& options) {
  std::string page =
      "# Doubtful inputs\n\n"
      "How public scorers treat faulty results files, and how Enfilade treats the same files. "
      "The first three columns were\n"
      "recorded by running the public code. `check_vectors --doubtful --page` "
      "(`tests/conformance/`) writes this page. A test\n"
      "compares it where the recordings lie beside the data.\n\n"
      "- *the same means* (*values*, in continuous space): Enfilade reads the file and computes"
      " what the public code computes.\n"
      "- *other means*: Enfilade reads the file and computes other means. The public code "
      "counts an entry twice, or omits one.\n"
      "- *scored*: Enfilade scores the file, where the public code ends with an error.\n"
      "- *fault*: Enfilade refuses the file. The codes of its faults follow; each message names"
      " the JSON path.\n\n"
      "Enfilade never counts silently. A missing, repeated or unknown instruction is a fault "
      "for every benchmark, whatever its\n"
      "public scorer does.\n";
  for (const std::string& file : options.files) page += doubtful_table(file, options);
  return page;
}

ExitCode check_doubtful(const Options& options) {
  const std::string page = doubtful_page(options);
  if (options.page.empty()) {
    fmt::print("{}", page);
  } else if (options.write_page) {
    write_file_atomically(options.page, page);
  } else if (read_file(options.page) != page) {
    fmt::print("{}: is not what the recorded inputs give; run with --write\n", options.page);
    return kFaultsFound;
  }
  return kSuccess;
}

ExitCode check(const Options& options) {
  if (options.doubtful) return check_doubtful(options);
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
  app.add_option("--page", options.page,
                 "With --doubtful: a page to compare with what would be printed")
      ->type_name("FILE.md");
  app.add_flag("--write", options.write_page, "With --page: write it");
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
