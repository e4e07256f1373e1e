#include "apps/enfilade/arena_world.h"

#include <fmt/format.h>
#include <pthread.h>
#include <csignal>
#include <cstdio>

#include "apps/common/program.h"

namespace enfilade::apps {

void serve_mcp_over_http(arena::McpServer& server, int port, const std::string& done) {
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGINT);
  sigaddset(&ends, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);  // the threads of the server inherit it
  const arena::McpHttp http(server, {.port = port});
  say("{}; an assistant is waited for at {}\n", done, http.url());
  std::fflush(stdout);
  int signal = 0;
  sigwait(&ends, &signal);
}

}  // namespace enfilade::apps
