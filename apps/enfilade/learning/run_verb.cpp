#include "apps/enfilade/learning/run_verb.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/wait.h>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "apps/common/program.h"
#include "enfilade/core/errors.h"

extern char** environ;

namespace enfilade::apps {
namespace {

int wait_for(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : kInternal;
}

}  // namespace

int run_verb(const std::vector<std::string>& words) {
  fmt::print("\n$ enfilade {}\n", fmt::join(words, " "));
  std::fflush(stdout);
  std::string program = own_program().string();
  std::vector<char*> arguments{program.data()};
  std::vector<std::string> copy = words;
  for (std::string& word : copy) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const Stopwatch clock;
  pid_t child = 0;
  const int error =
      posix_spawn(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ);
  if (error != 0) {
    throw FileError(fmt::format("{}: cannot be started: {}", program, std::strerror(error)));
  }
  const int status = wait_for(child);
  if (status == 0) fmt::print("({:.0f} s)\n", clock.seconds());
  return status;
}

}  // namespace enfilade::apps
