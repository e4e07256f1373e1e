// Sessions of the arena at a server of its own: how long a call takes, and a picture, for one
// walker and for many at once.
//   session_crowd DATA SPLIT [WALKERS [PIXELS]]
#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/service/server.h"
#include "tests/support/served_data.h"  // httplib
#include "tests/support/temporary_folder.h"

namespace enfilade::service {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

struct Times {
  std::mutex mutex;
  std::vector<double> calls, pictures;  // milliseconds
  std::size_t errors = 0;
};

class Walker {
 public:
  Walker(int port, std::string split, std::string episode, std::uint64_t seed)
      : client_("127.0.0.1", port), rng_(seed) {
    client_.set_keep_alive(true);
    client_.set_tcp_nodelay(true);
    const json wanted{{"split", std::move(split)}, {"episode", std::move(episode)}};
    take(client_.Post("/api/v1/sessions", wanted.dump(), "application/json"));
    if (!state_.contains("key")) return;
    path_ = fmt::format("/api/v1/sessions/{}", state_.at("session").get<std::int64_t>());
    headers_ = {{"Enfilade-Session", state_.at("key").get<std::string>()}};
  }

  // Walks anywhere until the limit on steps. \param pixels of a strip at each step; 0: none
  void walk(int pixels, Times& times) {
    std::vector<double> calls, pictures;
    while (!path_.empty() && state_.value("ending", json()).is_null()) {
      if (pixels > 0) pictures.push_back(timed([&] { look(pixels); }));
      calls.push_back(timed([&] { go(); }));
    }
    const std::scoped_lock lock(times.mutex);
    times.calls.insert(times.calls.end(), calls.begin(), calls.end());
    times.pictures.insert(times.pictures.end(), pictures.begin(), pictures.end());
    times.errors += errors_;
  }

 private:
  template <class Do>
  static double timed(const Do& what) {
    const auto begin = Clock::now();
    what();
    return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  }
  void take(const httplib::Result& answer) {
    if (answer && answer->status < 300) {
      state_ = json::parse(answer->body);
    } else {
      ++errors_;
      state_["ending"] = "error";
    }
  }
  void look(int pixels) {
    const auto answer =
        client_.Get(fmt::format("{}/pictures/strip/0?size={}", path_, pixels), headers_);
    if (!answer || answer->status != 200) ++errors_;
  }
  void go() {
    const json& places = state_.at("observation").at("places");
    const json body{{"tool", "go_to"},
                    {"argument", places.at(rng_.below(places.size())).at("name")}};
    take(client_.Post(path_ + "/calls", headers_, body.dump(), "application/json"));
  }

  httplib::Client client_;
  Rng rng_;
  json state_;
  std::string path_;
  httplib::Headers headers_;
  std::size_t errors_ = 0;
};

void tell(const std::string& what, std::vector<double>& times) {
  if (times.empty()) return;
  std::ranges::sort(times);
  const auto at = [&](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  fmt::print("{:<40} {:>6}  median {:6.2f} ms  p99 {:6.2f} ms  longest {:6.2f} ms\n", what,
             times.size(), at(0.5), at(0.99), times.back());
}

int run(const std::vector<std::string>& words) {
  if (words.size() < 2) {
    fmt::print(stderr, "usage: session_crowd DATA SPLIT [WALKERS [PIXELS]]\n");
    return 2;
  }
  const std::string& split = words[1];
  const std::size_t many = words.size() > 2 ? std::stoul(words[2]) : 64;
  const int pixels = words.size() > 3 ? std::stoi(words[3]) : 512;
  const tests::TemporaryFolder folder("sessions");
  ServerConfig config;
  config.database = folder.path() / "sessions.sqlite";
  config.port = 0;
  config.most_joins = 100'000;
  const Server server(Site::open(words[0]), config);
  httplib::Client client("127.0.0.1", server.port());
  const auto listed = client.Get(fmt::format("/api/v1/splits/{}/episodes?limit=500", split));
  std::vector<std::string> episodes;
  const json answer = json::parse(listed->body);
  for (const json& one : answer.at("episodes")) {
    episodes.push_back(one.at("instruction_id").get<std::string>());
  }
  std::size_t errors = 0;
  for (const std::size_t walkers : {std::size_t{1}, many}) {
    for (const int size : {0, pixels}) {
      Times times;
      std::vector<std::thread> threads;
      for (std::size_t k = 0; k < walkers; ++k) {
        threads.emplace_back([&, k] {
          for (std::size_t again = 0; again < (walkers == 1 ? 8 : 1); ++again) {
            Walker(server.port(), split, episodes[(7 * k + again) % episodes.size()], k + again)
                .walk(size, times);
          }
        });
      }
      for (std::thread& thread : threads) thread.join();
      const std::string who = fmt::format("{} walker{}", walkers, walkers == 1 ? "" : "s at once");
      tell(who + (size > 0 ? ", beside pictures: calls" : ": calls"), times.calls);
      tell(fmt::format("{}: strips, {} pixels", who, size), times.pictures);
      errors += times.errors;
    }
  }
  fmt::print("{} errors\n", errors);
  return errors == 0 ? 0 : 1;
}

}  // namespace
}  // namespace enfilade::service

int main(int count, char** words) { return enfilade::service::run({words + 1, words + count}); }
