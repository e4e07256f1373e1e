// The verbs that need a server, in a build without it: they report what is missing.
#include <string>

#include "apps/common/program.h"
#include "apps/enfilade/arena_world.h"
#include "apps/enfilade/verbs.h"

namespace enfilade::apps {
namespace {

void add_missing(CLI::App& app, const std::string& name, const std::string& what) {
  CLI::App& verb = *app.add_subcommand(name, what + " (not in this build)");
  verb.allow_extras();
  verb.callback([name] {
    throw UsageError(name +
                     ": this build speaks no HTTP. ./enfilade.sh serve makes one that does; with "
                     "plain CMake it is -DEN_WITH_WEB=ON (docs/service.md)");
  });
}

}  // namespace

void serve_mcp_over_http(arena::McpServer& /*server*/, int /*port*/, const std::string& /*done*/) {
  throw UsageError("mcp --port: this build speaks no HTTP; without it, mcp uses standard input");
}

void ask_verb::add(CLI::App& app, int& /*status*/) {
  add_missing(app, "ask", "Evaluate a language model on a split");
}
void serve_verb::add(CLI::App& app, int& /*status*/) {
  add_missing(app, "serve", "Serve a data set, a leaderboard and annotation pages over HTTP");
}
void submit_verb::add(CLI::App& app, int& /*status*/) {
  add_missing(app, "submit", "Submit a results file to an Enfilade server");
}

}  // namespace enfilade::apps
