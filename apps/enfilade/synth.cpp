// enfilade synth: a small made-up data set.
#include <fmt/format.h>
#include <cstdint>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/homes/small_building.h"

namespace enfilade::apps {
namespace {

struct Options {
  std::string output;
  std::size_t buildings = 6;
  std::uint64_t seed = 1;
};

void write(const Options& options) {
  homes::write_small_dataset(options.output, options.buildings, options.seed);
  fmt::print(
      "{}: {} SYNTHETIC buildings with paths and instructions.\n"
      "Use them with --data {} or ENFILADE_DATA; numbers from them compare with no others.\n",
      options.output, options.buildings, options.output);
}

}  // namespace

void add_synth(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand(
      "synth", "Write a small synthetic data set, for machines that have no real one");
  const auto options = std::make_shared<Options>();
  verb.add_option("-o,--output", options->output, "A new or empty folder")
      ->required()
      ->type_name("DIR");
  verb.add_option("--buildings", options->buildings, "Two-storey houses, 3 to 1000")
      ->check(whole_number())
      ->capture_default_str()
      ->type_name("N");
  verb.add_option("--seed", options->seed, "The same seed gives the same bytes")
      ->check(whole_number())
      ->capture_default_str();
  set_examples(verb, {"enfilade synth -o my-data", "enfilade stats --data my-data",
                      "enfilade graph draw synth_1 --data my-data"});
  verb.callback([options, &status] {
    write(*options);
    status = kSuccess;
  });
}

}  // namespace enfilade::apps
