#include "apps/enfilade/open_page.h"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>
#include <vector>

namespace enfilade::apps {
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): never set here
  return value == nullptr ? "" : value;
}

// BROWSER may name several, with colons between them; xdg-open needs a display.
std::vector<std::string> browsers() {
  std::vector<std::string> names;
  const std::string wanted = variable("BROWSER");
  for (std::size_t begin = 0; begin < wanted.size();) {
    const std::size_t end = std::min(wanted.find(':', begin), wanted.size());
    if (end > begin) names.push_back(wanted.substr(begin, end - begin));
    begin = end + 1;
  }
  if (!variable("DISPLAY").empty() || !variable("WAYLAND_DISPLAY").empty()) {
    names.emplace_back("xdg-open");
  }
  return names;
}

// Its own session and no output, so that it outlives this program and does not write into it.
bool start(const std::string& program, const std::string& file) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  std::string name = program, argument = file;
  std::array<char*, 3> arguments{name.data(), argument.data(), nullptr};
  pid_t child = 0;
  const int failed =
      posix_spawnp(&child, program.c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return failed == 0;
}

}  // namespace

bool open_page(const std::filesystem::path& file) {
  const std::string page = std::filesystem::absolute(file).string();
  for (const std::string& browser : browsers()) {
    if (start(browser, page)) return true;
  }
  return false;
}

}  // namespace enfilade::apps
