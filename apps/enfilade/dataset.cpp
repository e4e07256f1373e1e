// enfilade dataset: paths and instructions of all benchmarks for a folder of model homes.
#include <fmt/format.h>
#include <memory>

#include "apps/common/program.h"
#include "apps/enfilade/home_options.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/homes/home_set.h"

namespace enfilade::apps {
namespace dataset_verb {
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

void add_verb(CLI::App& app, int& /*status*/) {
  CLI::App& verb =
      *app.add_subcommand("dataset", "Make paths, instructions and splits for a folder of homes");
  const auto options = std::make_shared<Options>();
  add_value(verb, "folder", options->folder, "DIR", "Folder that enfilade homes made")->required();
  add_whole_number(verb, "--paths", options->paths.per_home, "Most paths per home");
  add_whole_number(verb, "--seed", options->paths.seed, "The same seed gives the same bytes", 0);
  add_setting(verb, "--val-seen", options->paths.val_seen_share, "",
              "Share of the training homes' paths, 0 to 1", finite_number(0, 0.99));
  add_tasks_option(verb, options->paths.tasks);
  add_threads_option(verb, options->paths.threads);
  set_examples(verb,
               {"enfilade homes -o homes --paths 0", "enfilade dataset homes --paths 100",
                "enfilade dataset homes --tasks reverie,soon", "enfilade stats --data homes"});
  verb.callback([options] { make(*options); });
}

}  // namespace
}  // namespace dataset_verb

void add_dataset(CLI::App& app, int& status) { dataset_verb::add_verb(app, status); }

}  // namespace enfilade::apps
