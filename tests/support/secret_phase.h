/// \file  A server with a phase whose goals are secret, for tests that try to read them.
#pragma once
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/tasks/annotations.h"
#include "tests/support/served_data.h"

namespace enfilade::service::testing {

using nlohmann::json;

inline constexpr std::int64_t kBegin = 1'000'000;
inline constexpr std::int64_t kPhaseEnd = 1'641'600;  // 1970-01-20T00:00:00Z
inline constexpr std::size_t kPaths = 60;
// A goal is 4 to 11 m from its start, so that whoever stays at the start fails for sure.
inline constexpr std::size_t kNearest = 4;
inline constexpr std::size_t kCandidates = 8;
inline constexpr std::size_t kLength = kPaths + kNearest + kCandidates;
inline const double kBitsOfAGoal = std::log2(static_cast<double>(kCandidates));

inline std::string viewpoint(std::size_t v) { return "v" + std::to_string(v); }

/// A trajectory of one path: back and forth between its first two viewpoints, each time 2 m of
/// detour, and then to `end` metres from the start.
struct Walk {
  std::size_t end = 0;
  std::size_t detours = 0;

  std::vector<std::size_t> steps() const {
    std::vector<std::size_t> offsets{0};
    for (std::size_t k = 0; k < detours; ++k) offsets.insert(offsets.end(), {1, 0});
    for (std::size_t v = 1; v <= end; ++v) offsets.push_back(v);
    return offsets;
  }
};
using Walks = std::array<Walk, kPaths>;

/// A results file of R2R.
inline std::string results_of(const Walks& walks) {
  auto file = json::array();
  for (std::size_t path = 0; path < kPaths; ++path) {
    auto trajectory = json::array();
    for (const std::size_t step : walks[path].steps()) {
      trajectory.push_back({viewpoint(path + step), 1.5, 0.0});
    }
    file.push_back({{"instr_id", std::to_string(path + 1) + "_0"}, {"trajectory", trajectory}});
  }
  return file.dump();
}

/// By path, which of its candidates the goal is.
using Goals = std::array<std::size_t, kPaths>;

inline Goals draw_goals(std::uint64_t seed) {
  Rng rng(seed);
  Goals goals{};
  for (std::size_t& goal : goals) goal = rng.below(kCandidates);
  return goals;
}

inline tasks::Annotations annotations_of(const Goals& goals, bool with_goals) {
  tasks::Annotations annotations{"hidden", "", {}};
  for (std::size_t path = 0; path < kPaths; ++path) {
    tasks::PathAnnotation one{static_cast<std::int64_t>(path) + 1,
                              "hall",
                              Radians(1.5),
                              {},
                              std::nullopt,
                              {"Walk down the hall."}};
    const std::size_t metres = with_goals ? kNearest + goals[path] : 0;
    for (std::size_t v = path; v <= path + metres; ++v) one.path.push_back(viewpoint(v));
    if (with_goals) one.distance = static_cast<double>(metres);
    annotations.paths.push_back(one);
  }
  return annotations;
}

/// The same paths as lines of RxR.
inline std::string guides_of(const Goals& goals, bool with_goals) {
  std::string lines;
  for (const tasks::PathAnnotation& one : annotations_of(goals, with_goals).paths) {
    lines += json{{"path_id", one.path_id},
                  {"instruction_id", one.path_id},
                  {"scan", one.scan},
                  {"heading", one.heading.value},
                  {"path", one.path},
                  {"language", "en-IN"},
                  {"instruction", one.instructions[0]},
                  {"timed_instruction", json::array()}}
                 .dump() +
             "\n";
  }
  return lines;
}

/// Fields of a phase that ends at kPhaseEnd.
inline constexpr const char* kEnds = R"(, "ends": "1970-01-20T00:00:00Z")";

/// A server with a long hall, and paths along it whose goals are secret.
class Target {
 public:
  /// \param rules fields of the phase "test", in JSON
  Target(const Goals& goals, const std::string& rules) {
    const auto data = served_.root() / "data";
    write_file_atomically(data / "connectivity/scans.txt", "row wing hall\n");
    write_file_atomically(data / "connectivity/hall_connectivity.json",
                          to_json(scan::testing::row_of_viewpoints("hall", kLength)));
    write_file_atomically(data / "r2r/R2R_hidden.json", to_json(annotations_of(goals, false)));
    write_file_atomically(served_.root() / "goals.json", to_json(annotations_of(goals, true)));
    serve("test", rules);
    organiser_ = served_.organiser();
  }
  /// The phase under another name, with other rules. From now on it is the one that is asked.
  void serve(const std::string& name, const std::string& rules) {
    served_.restart_with(
        R"({"split": "hidden", "annotations": "goals.json", "per_day": 1000, "name": ")" + name +
        '"' + rules + "}");
    phase_ = name;
  }
  /// From now on submissions are for this phase. \param results writes its files
  void ask(const std::string& phase, const std::function<std::string(const Walks&)>& results) {
    phase_ = phase;
    results_ = results;
  }

  Served& served() { return served_; }
  const httplib::Headers& organiser() const { return organiser_; }
  void end() { now_ = kPhaseEnd; }

  /// What the team sees of it when it has been scored, if it was taken.
  json submit(const httplib::Headers& team, const Walks& walks, const std::string& method) {
    const auto taken = served_.submit(team, phase_, results_(walks), method);
    json answer = json::parse(taken->body);
    if (taken->status != 202) return answer;
    const auto id = answer.at("id").get<std::int64_t>();
    served_.scored(organiser_, id);
    return served_.json("/api/v1/submissions/" + std::to_string(id), team);
  }
  /// Everything that the team can ask for, as text.
  std::string everything(const httplib::Headers& team) {
    std::string all;
    for (const char* target :
         {"/api/v1/phases", "/api/v1/submissions", "/api/v1/leaderboards/test",
          "/api/v1/leaderboards/test?all=1", "/api/v1/leaderboards/test?format=csv&all=1",
          "/api/v1/splits", "/api/v1/splits/hidden/episodes?limit=500", "/api/v1/session"}) {
      all += served_.get(target, team)->body + "\n";
    }
    return all;
  }
  /// What the server says that it has given away.
  double used_bits() {
    const json phases = served_.json("/api/v1/phases", organiser_).at("phases");
    return phases[0].at("leakage").at("used_bits").get<double>();
  }

 private:
  ServerConfig config() {
    ServerConfig config;
    config.clock = [this] { return now_.load(); };
    config.most_attempts = 1000;  // of registrations: that limit is not what is attacked here
    return config;
  }

  std::string phase_;
  std::function<std::string(const Walks&)> results_ = [](const Walks& w) { return results_of(w); };
  std::atomic<std::int64_t> now_{kBegin};
  Served served_{config()};
  httplib::Headers organiser_;
};

}  // namespace enfilade::service::testing
