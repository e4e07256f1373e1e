// enfilade submit: hands a results file in at a server.
#include <fmt/format.h>
#include <chrono>
#include <memory>
#include <thread>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/gzip.h"
#include "enfilade/service/client.h"

namespace enfilade::apps::submit_verb {
namespace {

struct Options {
  std::string results, server, phase, method, token_file;
  int wait = 60;
};

std::string token_of(const Options& options) {
  std::string token = read_secret(options.token_file, {"ENFILADE_TOKEN"});
  if (token.empty()) {
    throw UsageError(
        "submit: no token. Set ENFILADE_TOKEN or give --token-file FILE; the server's page "
        "\"Submit\" makes a team and its token");
  }
  return token;
}

// Why a submission has no means.
std::string explain(const std::string& withheld) {
  if (withheld == "until-end") return "its scores appear when the phase has ended";
  if (withheld == "no-improvement") return "it does not beat your team's best score by a step";
  if (withheld == "not-best") return "another submission of your team stands for it";
  return "its scores are the organisers' to see";
}

void print_means(const service::SubmissionStatus& status) {
  for (const auto& [metric, mean] : status.means) say("{:<20} {:.4f}\n", metric, mean);
  if (status.means.empty()) say("{}\n", explain(status.withheld));
}

ExitCode submit(const Options& options) {
  service::Client client(options.server, token_of(options));
  service::SubmissionStatus status;
  try {
    status = client.submit(options.phase, options.method, read_text_file(options.results));
  } catch (const InvalidInput& refused) {  // what was to be checked has faults
    print_diagnostics(refused.diagnostics());
    return kFaultsFound;
  }
  for (const std::string& warning : status.warnings) say(stderr, "{}\n", warning);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(options.wait);
  while (status.state == "queued" && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    status = client.status(status.id);
  }
  say("submission {}: {}\n", status.id, status.state);
  if (status.state == "scored" || status.state == "received") print_means(status);
  return status.state == "failed" ? kInput : kSuccess;
}

}  // namespace

void add(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand("submit", "Submit a results file to an Enfilade server");
  const auto options = std::make_shared<Options>();
  add_value(verb, "results", options->results, "RESULTS.json",
            "Results file, in any of the usual forms")
      ->required();
  add_value(verb, "--server", options->server, "URL", "Address of the server")->required();
  add_value(verb, "--phase", options->phase, "NAME", "Phase of the server's leaderboard")
      ->required();
  add_value(verb, "--method", options->method, "NAME", "Name of the method on the leaderboard")
      ->required();
  add_value(verb, "--token-file", options->token_file, "FILE",
            "The team's token (default: the environment variable ENFILADE_TOKEN)");
  add_setting(verb, "--wait", options->wait, "", "Seconds to wait for the scores",
              CLI::Range(0, 3600));
  set_examples(verb, {"enfilade submit results.json --server https://vln.example.org --phase test "
                      "--method Seq2Seq"});
  verb.callback([options, &status] { status = submit(*options); });
}

}  // namespace enfilade::apps::submit_verb
