// replay_mattersim: does again what recorded runs of MatterSim did and compares every state.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "tests/conformance/data_beside.h"
#include "tests/conformance/replay.h"
#include "tests/conformance/trace.h"

namespace enfilade::tests {
namespace {

using namespace apps;

constexpr std::size_t kShown = 10;  // mismatches, without --verbose

struct Options {
  std::vector<std::string> files;
  std::string data;
  double tolerance = 1e-6;
  bool verbose = false;
};

struct Counts {
  std::size_t states = 0;
  std::size_t mismatched = 0;  // states with a mismatch
  std::size_t identical = 0;   // to the bit
};

void print_mismatches(const std::string& file, const TraceStep& step, std::size_t state,
                      const Comparison& comparison, bool verbose, std::size_t& shown) {
  for (const Mismatch& mismatch : comparison.mismatches) {
    if (!verbose && shown == kShown) return;
    ++shown;
    fmt::print("{}:{}: state {} ({}, {}): {}: expected {}, got {}\n", file, step.line, state,
               step.scan, step.config, mismatch.field, mismatch.expected, mismatch.got);
  }
}

Counts replay_file(const std::string& file, const Options& options, std::size_t& shown) {
  TraceReader reader(file);
  const auto graphs = open_data_beside(options.data, file).graphs();
  Replay replay(graphs, reader.header(), options.tolerance);
  Counts counts;
  std::map<std::string, Counts> by_config;
  while (const auto step = reader.next()) {
    const std::size_t state = counts.states;
    Comparison comparison;
    try {
      comparison = replay.compare(*step);
    } catch (const LookupError& error) {  // the trace and the data set don't belong together
      throw FileError(fmt::format("{}:{}: {}", file, step->line, error.what()));
    }
    print_mismatches(file, *step, state, comparison, options.verbose, shown);
    for (Counts* sum : {&counts, &by_config[step->config]}) {
      ++sum->states;
      sum->mismatched += comparison.mismatches.empty() ? 0 : 1;
      sum->identical += comparison.identical ? 1 : 0;
    }
  }
  if (options.verbose) {
    for (const auto& [name, sum] : by_config) {
      fmt::print("{}: {}: {} states, {} mismatches, {} identical to the bit\n", file, name,
                 sum.states, sum.mismatched, sum.identical);
    }
  }
  return counts;
}

int replay_all(const Options& options) {
  Counts total;
  std::size_t shown = 0;
  for (const std::string& file : options.files) {
    const Counts counts = replay_file(file, options, shown);
    total.states += counts.states;
    total.mismatched += counts.mismatched;
    total.identical += counts.identical;
  }
  fmt::print("{} of {} states identical to the bit\n", total.identical, total.states);
  fmt::print("{} states, {} mismatches\n", total.states, total.mismatched);
  return total.mismatched > 0 ? kFaultsFound : kSuccess;
}

}  // namespace
}  // namespace enfilade::tests

int main(int argc, char** argv) {
  using namespace enfilade::tests;
  CLI::App app(
      "Replays recorded runs of MatterSim through Enfilade's simulator. Counts the states in "
      "which\n"
      "an id, an index, the order, a step or a view differs at all, or a real number by more than\n"
      "the tolerance.",
      "replay_mattersim");
  Options options;
  int status = kSuccess;
  app.add_option("files", options.files, "Traces: .jsonl or .jsonl.gz")
      ->required()
      ->type_name("FILE...");
  app.add_option("--data", options.data,
                 "Data set with the graphs (default: ENFILADE_DATA, then ../data beside the "
                 "file's folder)")
      ->type_name("DIR");
  app.add_option("--tolerance", options.tolerance, "How far real numbers may be off")
      ->check(finite_number())
      ->capture_default_str();
  app.add_flag("--verbose", options.verbose,
               "Every mismatch, not the first 10, and the counts of each configuration");
  set_examples(app, {"replay_mattersim traces_public.jsonl.gz",
                     "replay_mattersim --tolerance 0 --verbose traces_v01_public.jsonl.gz"});
  app.callback([&] { status = replay_all(options); });
  return run_program(app, argc, argv, status);
}
