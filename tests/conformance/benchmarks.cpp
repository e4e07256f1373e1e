#include "tests/conformance/benchmarks.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/continuous_score.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/scorer.h"

namespace enfilade::tests {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using tasks::EpisodeSet;
using tasks::Scorer;
using tasks::Task;
using tasks::Trajectory;

constexpr std::size_t kExamples = 10;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// What is recorded: a number, a truth value, "nan", "inf", or an error, which has no value.
double recorded(const Json& value) {
  if (value.is_boolean()) return value.get<bool>() ? 1 : 0;
  if (value.is_number()) return value.get<double>();
  if (value == "inf") return std::numeric_limits<double>::infinity();
  if (value == "-inf") return -std::numeric_limits<double>::infinity();
  return kNone;
}

bool agree(double ours, double theirs, double tolerance) {
  if (std::isnan(theirs) || std::isinf(theirs)) {
    return std::isnan(theirs) ? std::isnan(ours) : ours == theirs;
  }
  return std::abs(ours - theirs) <= tolerance * std::max(1.0, std::abs(theirs));
}

// Gathers cases of one file.
class Check {
 public:
  Check(VectorReport& report, double tolerance) : report_(report), tolerance_(tolerance) {}

  // One case: values by name.
  void compare(const std::string& where, const Json& expected,
               const std::map<std::string, double>& ours) {
    std::string text;
    for (const auto& [name, value] : expected.items()) {
      const auto found = ours.find(name);
      const double theirs = recorded(value);
      if (found != ours.end() && agree(found->second, theirs, tolerance_)) continue;
      text +=
          fmt::format("{}{} is {}, expected {}", text.empty() ? "" : "; ", name,
                      found == ours.end() ? "missing" : fmt::format("{}", found->second), theirs);
    }
    ++report_.cases;
    if (text.empty()) return;
    if (++report_.mismatches <= kExamples) report_.examples.push_back(where + ": " + text);
  }

 private:
  VectorReport& report_;
  double tolerance_;
};

std::map<std::string, double> by_name(const Scorer& scorer, std::span<const double> values) {
  std::map<std::string, double> named;
  for (std::size_t k = 0; k < values.size(); ++k) named[scorer.metrics[k].name] = values[k];
  return named;
}

std::map<std::string, double> by_mean_name(const Scorer& scorer, std::span<const double> means) {
  std::map<std::string, double> named;
  for (std::size_t k = 0; k < means.size(); ++k) {
    if (scorer.metrics[k].rule == tasks::MeanRule::kNone) continue;
    named[scorer.metrics[k].mean_name()] = means[k];
  }
  return named;
}

// SOON's released scorer has no values of an episode: what is recorded is its summary of one.
bool summarises_one(const Scorer& scorer) {
  return std::ranges::any_of(scorer.metrics, [](const tasks::ScorerMetric& m) {
    return m.rule == tasks::MeanRule::kGuarded;
  });
}

std::vector<double> score_one(const Scorer& scorer, const EpisodeSet& episodes,
                              const Trajectory& trajectory) {
  const tasks::Episode& episode = episodes.episodes.at(trajectory.episode);
  std::vector<double> values(scorer.metrics.size());
  scorer.on_graph({episodes.graph_of(episode), episodes.path_of(episode), trajectory}, values);
  return values;
}

void compare_one(Check& check, const std::string& where, const Scorer& scorer, const Json& expected,
                 std::span<const double> values) {
  if (!summarises_one(scorer)) {
    check.compare(where, expected, by_name(scorer, values));
    return;
  }
  check.compare(where, expected, by_mean_name(scorer, tasks::summarise(scorer, values)));
}

// Where recorded files are: `data/...` beside the data set's folder, others beside the vectors.
struct Places {
  fs::path vectors, data;
  fs::path of(const std::string& name) const {
    return name.starts_with("data/") ? data / name.substr(5) : vectors / name;
  }
};

std::optional<Task> task_of(const std::string& stem) {
  static const std::map<std::string, Task> kTasks{
      {"r2r", Task::kR2r},   {"r2r_last", Task::kR2rLast}, {"r2r_back", Task::kR2rBack},
      {"r4r", Task::kR4r},   {"rxr", Task::kRxr},          {"reverie", Task::kReverie},
      {"cvdn", Task::kCvdn}, {"soon", Task::kSoon}};
  const auto found = kTasks.find(stem);
  return found == kTasks.end() ? std::nullopt : std::optional(found->second);
}

// A prediction as a trajectory.
class Predictions {
 public:
  explicit Predictions(const EpisodeSet& episodes) : episodes_(episodes) {
    for (std::size_t i = 0; i < episodes.episodes.size(); ++i) {
      places_.emplace(episodes.episodes[i].instruction_id, i);
    }
  }

  Trajectory read(const Json& prediction) const {
    Trajectory trajectory;
    trajectory.episode = places_.at(prediction.at("instr_id").get<std::string>());
    const auto& graph = episodes_.graph_of(episodes_.episodes[trajectory.episode]);
    const auto viewpoint = [&graph](const Json& id) {
      return graph.find(id.get<std::string>()).value();
    };
    for (const Json& id : prediction.at("path")) {
      trajectory.points.push_back({viewpoint(id), Radians(0), Radians(0)});
    }
    if (prediction.contains("groups")) trajectory.actions = prediction.at("groups").size() - 1;
    if (prediction.contains("midstop") && prediction["midstop"].is_string()) {
      trajectory.turning_point = viewpoint(prediction["midstop"]);
    }
    if (prediction.contains("object")) {
      const Json& object = prediction["object"];
      trajectory.object = object.is_string() ? object.get<std::string>() : object.dump();
    }
    if (prediction.contains("obj_heading")) {
      trajectory.point = {prediction["obj_heading"].get<double>(),
                          prediction["obj_elevation"].get<double>()};
    }
    return trajectory;
  }

 private:
  const EpisodeSet& episodes_;
  std::map<std::string, std::size_t, std::less<>> places_;
};

// "hamt en-IN" is HAMT's mean over one language.
std::pair<std::string, std::string> split_language(Task task, const std::string& name) {
  const std::size_t blank = name.find(' ');
  if (task != Task::kRxr || blank == std::string::npos) return {name, ""};
  return {name.substr(0, blank), name.substr(blank + 1)};
}

void check_means(Check& check, const std::string& where, const EpisodeSet& episodes,
                 const std::vector<Trajectory>& trajectories, const Json& means) {
  for (const auto& [name, expected] : means.items()) {
    const auto [scorer_name, language] = split_language(episodes.task, name);
    const Scorer& scorer = tasks::benchmark(episodes.task).scorer(scorer_name);
    std::vector<double> values;
    for (const Trajectory& trajectory : trajectories) {
      const tasks::Episode& episode = episodes.episodes[trajectory.episode];
      if (!language.empty() && episode.details.language != language) continue;
      const auto one = score_one(scorer, episodes, trajectory);
      values.insert(values.end(), one.begin(), one.end());
    }
    check.compare(where + ".means." + name, expected,
                  by_mean_name(scorer, tasks::summarise(scorer, values)));
  }
}

void check_followers(Check& check, const std::string& where, const fs::path& file,
                     const EpisodeSet& episodes) {
  std::map<std::string, std::size_t> by_number;  // "26": what follows the last "_" of "11_26"
  for (std::size_t i = 0; i < episodes.episodes.size(); ++i) {
    const std::string& id = episodes.episodes[i].instruction_id;
    by_number.emplace(id.substr(id.rfind('_') + 1), i);
  }
  for (const tasks::Demonstration& d : tasks::load_demonstrations(file)) {
    const auto& episode = episodes.episodes[by_number.at(std::to_string(d.instruction_id))];
    const auto& graph = episodes.graph_of(episode);
    std::vector<ViewpointIndex> path;
    for (const std::string& id : d.path) path.push_back(graph.find(id).value());
    const auto m = tasks::compute_metrics(graph, path, episodes.path_of(episode).viewpoints);
    const Json expected{{"ne", d.ne},   {"sr", d.sr},     {"spl", d.spl},
                        {"dtw", d.dtw}, {"ndtw", d.ndtw}, {"sdtw", d.sdtw}};
    check.compare(fmt::format("{}.followers {}", where, d.demonstration_id), expected,
                  {{"ne", m.nav_error},
                   {"sr", m.success},
                   {"spl", m.spl},
                   {"dtw", m.dtw},
                   {"ndtw", m.ndtw},
                   {"sdtw", m.sdtw}});
  }
}

void check_set(Check& check, const Json& set, Task task, const Places& places,
               const std::shared_ptr<const graph::GraphSet>& graphs,
               const tasks::ObjectBoxes& objects) {
  const auto id = set.at("id").get<std::string>();
  const tasks::Annotations annotations =
      tasks::load_annotations(places.of(set.at("annotations").get<std::string>()), id, task);
  const EpisodeSet episodes =
      tasks::make_episodes(annotations, graphs, tasks::Instructions::kAll, &objects);
  const Predictions predictions(episodes);
  std::vector<Trajectory> trajectories;
  for (const Json& prediction : set.at("predictions")) {
    trajectories.push_back(predictions.read(prediction));
    const std::string where = fmt::format("{} {}", id, prediction.at("instr_id").dump());
    for (const auto& [name, expected] : prediction.at("scores").items()) {
      const Scorer& scorer = tasks::benchmark(task).scorer(name);
      compare_one(check, where + " " + name, scorer, expected,
                  score_one(scorer, episodes, trajectories.back()));
    }
  }
  check_means(check, id, episodes, trajectories, set.at("means"));
  if (set.contains("followers")) {
    check_followers(check, id, places.of(set.at("followers").get<std::string>()), episodes);
  }
}

// --- ends at exactly 3 m, on a graph of its own ---

struct Threshold {
  std::shared_ptr<const graph::GraphSet> graphs;
  std::vector<ViewpointIndex> reference;
};

std::vector<ViewpointIndex> there_and_back(std::vector<ViewpointIndex> path) {
  const std::size_t n = path.size();
  for (std::size_t k = n - 1; k-- > 0;) path.push_back(path[k]);
  return path;
}

tasks::Goal threshold_goal(Task task, const std::vector<ViewpointIndex>& reference) {
  if (task == Task::kR2rBack) return tasks::TurningPoint{reference.back()};
  if (task == Task::kCvdn) return tasks::Region{{reference.back()}, reference, reference};
  if (task != Task::kSoon) return tasks::NearEnd{};
  // A box around the heading 1; predictions point to 0.16 of a turn.
  constexpr double kHalf = 0.2;
  const auto at = [](double heading, double elevation) {
    return tasks::Direction{Radians(1 + heading), Radians(elevation)};
  };
  return tasks::Boxes{
      {{reference.back(),
        at(0, 0),
        {at(-kHalf, kHalf), at(kHalf, kHalf), at(kHalf, -kHalf), at(-kHalf, -kHalf)}}},
      {}};
}

// "soon duet", "cvdn official planner_path", "hamt r2r_back, ...", "hamt".
std::pair<Task, std::string> threshold_scorer(const std::string& name) {
  if (name.starts_with("soon ")) return {Task::kSoon, name.substr(5)};
  if (name.starts_with("cvdn ")) return {Task::kCvdn, name.substr(5)};
  if (name.starts_with("hamt r2r_back")) return {Task::kR2rBack, "hamt"};
  return {Task::kR4r, name};
}

void check_threshold(Check& check, const Json& all, const Places& places) {
  const auto scan = all.at("scan").get<std::string>();
  const fs::path folder = places.of(all.at("connectivity").get<std::string>()).parent_path();
  const auto graphs = graph::GraphSet::open(folder, {scan});
  const graph::NavGraph& graph = graphs->graph(ScanIndex(0));
  const auto path_of = [&graph](const Json& ids) {
    std::vector<ViewpointIndex> path;
    for (const Json& id : ids) path.push_back(graph.find(id.get<std::string>()).value());
    return path;
  };
  const auto straight = path_of(all.at("reference"));
  for (const Json& set : all.at("sets")) {
    const auto walk = path_of(set.at("path"));
    for (const auto& [name, expected] : set.at("scores").items()) {
      const auto [task, scorer_name] = threshold_scorer(name);
      const bool back = task == Task::kR2rBack;
      tasks::ReferencePath reference;
      reference.viewpoints = back ? there_and_back(straight) : straight;
      reference.goal = threshold_goal(task, straight);
      Trajectory trajectory;
      for (const ViewpointIndex v : back ? there_and_back(walk) : walk) {
        trajectory.points.push_back({v, Radians(0), Radians(0)});
      }
      trajectory.turning_point = walk.back();
      trajectory.point = {0.16, 0.5};
      const Scorer& scorer = tasks::benchmark(task).scorer(scorer_name);
      std::vector<double> values(scorer.metrics.size());
      scorer.on_graph({graph, reference, trajectory}, values);
      compare_one(check, fmt::format("{}: {}", set.at("case").dump(), name), scorer, expected,
                  values);
    }
  }
}

// --- walks in continuous space ---

std::vector<tasks::Point3> reference_of(const Json& locations) {
  std::vector<tasks::Point3> points;
  for (const Json& point : locations) points.push_back(point.get<tasks::Point3>());
  return points;
}

// A recorded walk, which owns what a ContinuousWalk looks at.
struct RecordedWalk {
  explicit RecordedWalk(const Json& prediction)
      : positions(prediction.at("positions").get<std::vector<std::array<float, 3>>>()),
        actions(prediction.at("actions").get<std::vector<std::uint8_t>>()),
        collided(actions.size()) {
    for (const Json& distance : prediction.at("distance")) distances.push_back(recorded(distance));
    if (!prediction.contains("collided")) return;
    // Counted by poses: the first action leads to pose 1.
    for (const Json& pose : prediction["collided"]) collided.at(pose.get<std::size_t>() - 1) = 1;
  }
  tasks::ContinuousWalk walk() const { return {positions, actions, distances, collided}; }

  std::vector<std::array<float, 3>> positions;
  std::vector<std::uint8_t> actions;
  std::vector<double> distances;
  std::vector<std::uint8_t> collided;
};

using Named = std::map<std::string, double>;

Named named(const tasks::ContinuousScore& s) {
  return {{"distance_to_goal", s.distance_to_goal},
          {"success", s.success},
          {"spl", s.spl},
          {"ndtw", s.ndtw},
          {"path_length", s.path_length},
          {"oracle_success", s.oracle_success},
          {"steps_taken", s.steps_taken},
          {"oracle_navigation_error", s.oracle_navigation_error},
          {"oracle_spl", s.oracle_spl},
          {"sdtw", s.sdtw},
          {"collisions", s.collisions.value_or(kNone)},
          {"ndtw_fastdtw", s.ndtw_fastdtw},
          {"ndtw_fastdtw_compiled", s.ndtw_fastdtw_compiled},
          {"dtw", s.dtw}};
}

Named named(const tasks::EtpNavScore& s) {
  return {{"steps_taken", s.steps_taken},
          {"distance_to_goal", s.distance_to_goal},
          {"success", s.success},
          {"oracle_success", s.oracle_success},
          {"path_length", s.path_length},
          {"collisions", s.collisions},
          {"spl", s.spl},
          {"ndtw", s.ndtw},
          {"sdtw", s.sdtw}};
}

void add(Named& sums, const Named& values) {
  for (const auto& [name, value] : values) sums[name] += value;
}

void check_means(Check& check, const std::string& where, const Json& expected, Named sums,
                 std::size_t n) {
  for (auto& [name, sum] : sums) sum /= static_cast<double>(n);
  check.compare(where, expected, sums);
}

void check_continuous_set(Check& check, const Json& set, const Places& places) {
  const auto id = set.at("id").get<std::string>();
  const Json references = Json::parse(read_text_file(places.of(set.at("gt").get<std::string>())));
  Named vlnce, etpnav;
  for (const Json& prediction : set.at("predictions")) {
    const auto episode = prediction.at("episode_id").get<std::string>();
    const auto reference = reference_of(references.at(episode).at("locations"));
    const RecordedWalk recording(prediction);
    const std::string where = fmt::format("{} {} {}", id, episode, prediction.at("kind").dump());
    const Named ours = named(tasks::score_continuous(recording.walk(), reference));
    const Named theirs = named(tasks::score_as_etpnav(recording.walk(), reference));
    check.compare(where + " vlnce", prediction.at("scores").at("vlnce"), ours);
    check.compare(where + " etpnav", prediction.at("scores").at("etpnav"), theirs);
    add(vlnce, ours);
    add(etpnav, theirs);
    if (!prediction.contains("trace")) continue;
    const Json& trace = prediction["trace"];
    for (std::size_t k = 0; k < trace.size(); ++k) {
      check.compare(fmt::format("{} trace[{}]", where, k), trace[k],
                    named(tasks::score_continuous(recording.walk(), reference, k)));
    }
  }
  const std::size_t n = set.at("predictions").size();
  check_means(check, id + ".means.vlnce", set.at("means").at("vlnce"), vlnce, n);
  check_means(check, id + ".means.etpnav", set.at("means").at("etpnav"), etpnav, n);
}

// What ours has where the public code has an outcome.
DoubtfulInput doubtful_walk(const std::string& scorer, const Json& input, const Named& ours) {
  const Json& outcome = input.at("outcome").at(scorer);
  DoubtfulInput row{scorer, input.at("case").get<std::string>(), "values", "the same values"};
  if (outcome.contains("error")) {
    const auto error = outcome["error"].get<std::string>();
    row.theirs = error.substr(0, error.find(':'));
    row.ours = std::isnan(ours.at("spl")) ? "scored; SPL is not a number" : "scored";
    return row;
  }
  VectorReport report;
  Check(report, 1e-5).compare(scorer, outcome, ours);
  if (report.mismatches > 0) row.ours = "other values";
  return row;
}

}  // namespace

std::vector<DoubtfulInput> doubtful_walks(const fs::path& file, const fs::path& data) {
  std::vector<DoubtfulInput> rows;
  const Places places{file.parent_path(), data};
  try {
    const Json all = Json::parse(read_file(file));
    std::vector<Json> experts;  // of each set, by episode: ids of two sets may be the same
    for (const Json& set : all.at("sets")) {
      experts.push_back(Json::parse(read_text_file(places.of(set.at("gt").get<std::string>()))));
    }
    for (const Json& input : all.at("behaviour")) {
      const RecordedWalk recording(input);
      const auto id = input.at("episode_id").get<std::string>();
      const auto expert = std::ranges::find_if(experts, [&](const Json& of_set) {
        return of_set.contains(id) &&
               of_set[id].at("locations").front().get<std::array<float, 3>>() ==
                   recording.positions.front();
      });
      if (expert == experts.end())
        throw FileError(fmt::format("{}: no episode {}", file.string(), id));
      const auto reference = reference_of(expert->at(id).at("locations"));
      rows.push_back(doubtful_walk("vlnce", input,
                                   named(tasks::score_continuous(recording.walk(), reference))));
      rows.push_back(doubtful_walk("etpnav", input,
                                   named(tasks::score_as_etpnav(recording.walk(), reference))));
    }
  } catch (const Json::exception& error) {
    throw FileError(fmt::format("{}: not of the form expected: {}", file.string(), error.what()));
  }
  return rows;
}

bool is_benchmark_file(const fs::path& file) {
  try {
    const Json all = Json::parse(read_file(file));
    return all.is_object() && all.contains("scorers") && all.contains("sets");
  } catch (const Json::parse_error&) {
    return false;  // whoever reads it says what is wrong
  }
}

VectorReport check_benchmark(const fs::path& file, const fs::path& data,
                             const std::shared_ptr<const graph::GraphSet>& graphs,
                             const VectorTolerances& tolerances) {
  VectorReport report;
  Check check(report, tolerances.metrics);
  const Places places{file.parent_path(), data};
  try {
    const Json all = Json::parse(read_file(file));
    const std::string stem = file.stem().string();
    if (stem == "threshold") {
      check_threshold(check, all, places);
      return report;
    }
    if (stem == "vlnce") {
      // The public measures work in single precision here and there.
      Check single(report, std::max(tolerances.metrics, 1e-5));
      for (const Json& set : all.at("sets")) check_continuous_set(single, set, places);
      return report;
    }
    const auto task = task_of(stem);
    if (!task) {
      throw FileError(fmt::format("{}: {:?} names no benchmark", file.string(), stem));
    }
    const auto objects = *task == Task::kReverie
                             ? tasks::ObjectBoxes::load(places.of("data/reverie/BBox.json.gz"))
                             : tasks::ObjectBoxes();
    for (const Json& set : all.at("sets")) check_set(check, set, *task, places, graphs, objects);
  } catch (const Json::exception& error) {
    throw FileError(fmt::format("{}: not of the form expected: {}", file.string(), error.what()));
  }
  return report;
}

}  // namespace enfilade::tests
