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

namespace fs = std::filesystem;

struct Options {
  std::size_t shards = 16, cpus = 1, attempts = 5;
  std::string folder = "job", commands, address, python = "python3";
  Words words;
};

void run(const Options& options) {
  const ClusterJob job = job_of(options.words, options.shards, options.commands);
  const fs::path folder = fs::absolute(options.folder).lexically_normal();
  claim_job_folder(folder, job);
  std::vector<std::string> words{options.python,     "-m",
                                 "enfilade.cluster", folder.string(),
                                 "--cpus",           std::to_string(options.cpus),
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
  CLI::App& verb = *app.add_subcommand("ray", "Cut a data job into shares, as tasks of Ray");
  const auto options = std::make_shared<Options>();
  verb.prefix_command();
  add_whole_number(verb, "--shards", options->shards, "How many shares");
  add_value(verb, "--commands", options->commands, "FILE",
            "In place of a verb: a command a line, each a share, such as evaluate, pack or export");
  add_setting(verb, "-o,--output", options->folder, "DIR",
              "For logs and what is done; on a file system that all machines see");
  add_whole_number(verb, "--cpus", options->cpus, "Processors a share");
  add_whole_number(verb, "--attempts", options->attempts, "Times that a share is begun");
  add_value(verb, "--address", options->address, "ADDRESS",
            "Of a running cluster: auto, or HOST:PORT (default: one on this machine alone)");
  add_setting(verb, "--python", options->python, "PROGRAM",
              "A Python with the packages enfilade and ray");
  set_examples(verb, {"enfilade ray --shards 16 homes -o homes --preset full",
                      "enfilade ray --address auto --cpus 8 features --data homes --weights "
                      "resnet152.pth -o features.safetensors",
                      "enfilade ray --commands evaluations.txt -o evaluations"});
  verb.callback([options, &verb] {
    options->words = verb.remaining();
    run(*options);
  });
}

}  // namespace
}  // namespace ray_verb

void add_ray(CLI::App& app, int& status) { ray_verb::add_verb(app, status); }

}  // namespace enfilade::apps
