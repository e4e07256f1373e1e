// enfilade dataset: Room-to-Room paths and instructions for a folder of model homes.
#include <fmt/format.h>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/homes/home_set.h"

namespace enfilade::apps {
namespace {

struct Options {
  std::string folder;
  homes::HomePathOptions paths;
};

void make(const Options& options) {
  const Progress progress = progress_bar("paths");
  const auto report = homes::write_home_paths(
      options.folder, options.paths, [&](const std::string&, std::size_t done, std::size_t total) {
        if (progress) progress(done, total);
      });
  fmt::print(
      "{0}/r2r: {1} paths, {2} instructions, all SYNTHETIC; whole test paths in {0}/hidden\n",
      options.folder, report.paths, report.instructions);
}

}  // namespace

void add_dataset(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand(
      "dataset", "Paths, three instructions each, and splits for a folder of model homes");
  const auto options = std::make_shared<Options>();
  verb.add_option("folder", options->folder, "Made by enfilade homes")
      ->required()
      ->type_name("DIR");
  verb.add_option("--paths", options->paths.per_home, "A home, at most")
      ->check(whole_number(1))
      ->capture_default_str();
  verb.add_option("--seed", options->paths.seed, "The same seed gives the same bytes")
      ->check(whole_number())
      ->capture_default_str();
  verb.add_option("--val-seen", options->paths.val_seen_share,
                  "Share of the training homes' paths, 0 to 1")
      ->check(finite_number(0, 0.99))
      ->capture_default_str();
  verb.add_option("--threads", options->paths.threads, "0: all cores")
      ->check(whole_number(0, 1024))
      ->capture_default_str();
  set_examples(verb, {"enfilade homes -o homes --paths 0", "enfilade dataset homes --paths 100",
                      "enfilade stats --data homes"});
  verb.callback([options, &status] {
    make(*options);
    status = kSuccess;
  });
}

}  // namespace enfilade::apps
