#include "apps/enfilade/first_visit.h"

#include <fmt/format.h>
#include <array>
#include <chrono>
#include <string>
#include <thread>

#include "apps/common/program.h"
#include "enfilade/agents/run.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/service/client.h"
#include "enfilade/tasks/results.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

// Written after everything else of a set of homes without a test split.
bool is_complete(const fs::path& homes) {
  return fs::exists(homes / "r2r" / "R2R_val_unseen.json");
}

homes::SetProgress bar(const std::string& what) {
  return [progress = progress_bar(what)](const std::string&, std::size_t done, std::size_t total) {
    if (progress) progress(done, total);
  };
}

struct FirstAgent {
  const char* name;  // as agents::make_agent()
  const char* team;
  const char* method;
};
constexpr std::array<FirstAgent, 2> kAgents{
    {{"shortest", "Baseline: Shortest", "Shortest path, told the goals (SYNTHETIC homes)"},
     {"random", "Baseline: Random", "Random heading, then five moves (SYNTHETIC homes)"}}};

// The token of a new team, or of the one that an earlier start has made.
std::string token_of(const std::string& database, const std::string& team) {
  constexpr int kDays = 1;
  try {
    return service::create_team(database, team);
  } catch (const FileError&) {
    throw;
  } catch (const Error&) {
    return service::create_token(database, service::TokenRole::kTeam, team, kDays);
  }
}

void wait_until_scored(service::Client& client, std::int64_t submission) {
  constexpr std::chrono::milliseconds kPause{20};
  constexpr int kMostPauses = 1500;  // half a minute
  for (int k = 0; k < kMostPauses && client.status(submission).state == "queued"; ++k) {
    std::this_thread::sleep_for(kPause);
  }
}

}  // namespace

fs::path make_first_homes() {
  const fs::path of_demo = "enfilade-demo/homes", own = "enfilade-demo/two-homes";
  if (is_complete(of_demo)) return of_demo;
  if (is_complete(own)) return own;
  fmt::print(
      "No data set is named, and ENFILADE_DATA is not set. So two model homes, which are "
      "SYNTHETIC,\n"
      "are made in {}, once. If it is stopped, the next start goes on.\n",
      fs::absolute(own).string());
  std::fflush(stdout);
  homes::HomeSetOptions two = homes::home_set_preset("pretty");
  two.homes = 2;
  two.stairs_every = 0;
  two.least_area = two.most_area = 60;  // square metres: less than a minute of two cores for both
  two.face_size = 512;
  homes::write_homes(own, two, bar("two model homes"));
  homes::HomePathOptions paths;
  paths.test_split = false;
  homes::write_home_paths(own, paths, bar("instructions"));
  return own;
}

void submit_first_agents(const fs::path& data, const service::Site& site,
                         const std::string& database, const std::string& server) {
  const dataset::Dataset dataset(data);
  for (const FirstAgent& first : kAgents) {
    const auto agent = agents::make_agent(first.name);
    service::Client client(server, token_of(database, first.team));
    for (const service::Phase& phase : site.phases()) {
      const tasks::EpisodeSet episodes = dataset.episodes(phase.split);
      const std::string results = to_json(agents::run_agent(*agent, episodes), episodes);
      wait_until_scored(client, client.submit(phase.name, first.method, results).id);
    }
    service::revoke_tokens(database, service::TokenRole::kTeam, first.team);
  }
}

}  // namespace enfilade::apps
