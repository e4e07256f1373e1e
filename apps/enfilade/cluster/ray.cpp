// enfilade ray: a data job as tasks of Ray, by the Python package.
#include <fmt/format.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/cluster/job.h"
#include "apps/enfilade/verbs.h"

namespace enfilade::apps {
namespace ray_verb {
namespace {

struct Options {
  JobOptions job;
  std::size_t attempts = 5;
  std::string address, python = "python3";
};

void run(const CLI::App& verb, const Options& options) {
  const std::filesystem::path folder = claim_job(verb, options.job).folder;
  std::vector<std::string> words{options.python,     "-m",
                                 "enfilade.cluster", folder.string(),
                                 "--cpus",           std::to_string(options.job.cpus),
                                 "--attempts",       std::to_string(options.attempts)};
  if (!options.address.empty()) words.insert(words.end(), {"--address", options.address});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::fflush(stdout);
  execvp(arguments[0], arguments.data());
  throw UsageError(
      fmt::format("ray: {}: {}; --python names another", options.python, std::strerror(errno)));
}

void add_verb(CLI::App& app, int& /*status*/) {
  CLI::App& verb = *app.add_subcommand("ray", "Run a data job in shards, as tasks of Ray");
  const auto options = std::make_shared<Options>();
  add_job_options(verb, options->job);
  add_whole_number(verb, "--attempts", options->attempts, "Most attempts per shard");
  add_value(verb, "--address", options->address, "ADDRESS",
            "Address of a running cluster: auto, or HOST:PORT (default: one on this machine "
            "alone)");
  add_setting(verb, "--python", options->python, "PROGRAM",
              "Python with the packages enfilade and ray");
  set_examples(verb, {"enfilade ray --shards 16 homes -o homes --preset full",
                      "enfilade ray --address auto --cpus 8 features --data homes --weights "
                      "resnet152.pth -o features.safetensors",
                      "enfilade ray --commands evaluations.txt -o evaluations"});
  verb.callback([options, &verb] { run(verb, *options); });
}

}  // namespace
}  // namespace ray_verb

void add_ray(CLI::App& app, int& status) { ray_verb::add_verb(app, status); }

}  // namespace enfilade::apps
