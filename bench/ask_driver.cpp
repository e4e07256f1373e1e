// What asking costs the machine that asks: a run against a stand-in in a process of its own that
// takes SECONDS for each answer, then the same run again from the cache alone.
//   ask_driver DATA SPLIT [PROMPT [EPISODES [PARALLEL [SECONDS]]]]
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <string>
#include <vector>

#include "enfilade/arena/ask.h"
#include "enfilade/arena/stand_in.h"
#include "enfilade/arena/world.h"
#include "enfilade/dataset/dataset.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::arena {
namespace {

struct Cost {
  double wall = 0, processor = 0;  // seconds
};

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

template <class Do>
Cost measure(const Do& what) {
  const double before = processor_seconds();
  const auto begin = std::chrono::steady_clock::now();
  what();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  return {wall.count(), processor_seconds() - before};
}

std::unique_ptr<GraphWorld> open(const dataset::Dataset& data, const std::string& split) {
  return std::make_unique<GraphWorld>(
      std::make_shared<const tasks::EpisodeSet>(data.episodes(split)));
}

/// A process that answers by the oracle, until it is killed. \pre no thread runs yet
struct Server {
  pid_t process = 0;
  std::string url;

  Server(const std::filesystem::path& folder, const std::string& split, double seconds) {
    int ends[2];
    if (pipe(ends) != 0) throw Error("no pipe");
    process = fork();
    if (process == 0) {
      const dataset::Dataset data(folder);
      StandInConfig config{.faults = {StandInFault::kSilence}, .one_in = 1, .silence = seconds};
      const StandIn model(open(data, split), config);
      const std::string line = model.url() + "\n";
      if (write(ends[1], line.data(), line.size()) < 0) _exit(1);
      pause();
    }
    for (char c = 0; read(ends[0], &c, 1) == 1 && c != '\n';) url += c;
  }
  ~Server() {
    kill(process, SIGKILL);
    waitpid(process, nullptr, 0);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
};

int run(const std::vector<std::string>& words) {
  if (words.size() < 2) {
    fmt::print(stderr, "ask_driver DATA SPLIT [PROMPT [EPISODES [PARALLEL [SECONDS]]]]\n");
    return 2;
  }
  const auto word = [&words](std::size_t k, const char* otherwise) {
    return words.size() > k ? words[k] : std::string(otherwise);
  };
  const Server server(words[0], words[1], std::stod(word(5, "1")));
  const auto data = std::make_shared<const dataset::Dataset>(words[0]);
  const auto world = open(*data, words[1]);
  const Prompt prompt = Prompt::open(word(2, "text"));
  const auto which = spread_subset(*world, std::stoul(word(3, "216")));
  AskConfig config;
  config.chat.model = "stand-in";
  config.parallel = std::stoul(word(4, "32"));
  const tests::TemporaryFolder folder("ask_driver");
  AnswerCache cache(folder.path() / "cache");
  const auto endpoint = make_http_endpoint({.url = server.url, .timeout = 60});
  AskReport asked, again;
  const Cost asking = measure([&] {
    asked = ask(*world, {.data = data}, which, prompt, config, endpoint.get(), cache,
                folder.path() / "asked");
  });
  const Cost replaying = measure([&] {
    again =
        ask(*world, {.data = data}, which, prompt, config, nullptr, cache, folder.path() / "again");
  });
  fmt::print("{} of {} episodes, {} answers, {} pictures, {} in flight\n", asked.done,
             asked.episodes, asked.ledger.answers, asked.ledger.pictures, config.parallel);
  fmt::print("asking     {:6.1f} s, {:.1f} s of the processor: {:.0f} % of a core\n", asking.wall,
             asking.processor, 100 * asking.processor / asking.wall);
  fmt::print("replaying  {:6.1f} s, {:.1f} s of the processor, {} episodes\n", replaying.wall,
             replaying.processor, again.done);
  return asked.done == asked.episodes && again.done == asked.done ? 0 : 1;
}

}  // namespace
}  // namespace enfilade::arena

int main(int count, char** words) { return enfilade::arena::run({words + 1, words + count}); }
