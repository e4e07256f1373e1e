// A benchmark of one's own in one file: a reader, a goal of a kind that there is, a list of
// metrics. "Stay near": a line is scan, start, number of moves and text, with tabs between; the
// goal is any viewpoint whose shortest path from the start has that many moves. A second metric
// says how many metres were walked beyond the shortest way to where the agent stopped.
#include <enfilade/core/file.h>
#include <enfilade/enfilade.h>
#include <enfilade/tasks/goal_distance.h>
#include <enfilade/tasks/score_table.h>

#include <array>
#include <iostream>
#include <sstream>

namespace {

using namespace enfilade;

// The goal is of CVDN's kind, to come to any viewpoint of a region: here those so many moves away.
tasks::NamedRegion region_around(const graph::NavGraph& graph, ViewpointIndex start,
                                 std::size_t moves) {
  tasks::NamedRegion region;
  for (std::size_t v = 0; v < graph.size(); ++v) {
    const auto path = graph.path(start, ViewpointIndex(v));
    if (path && path->size() == moves + 1) region.viewpoints.push_back(graph.id(ViewpointIndex(v)));
  }
  return region;
}

// A line's record; what is wrong with it where it has none.
std::string read_line(const std::string& line, const graph::GraphSet& graphs,
                      tasks::PathAnnotation& one) {
  std::istringstream fields(line);
  std::string start, words;
  std::size_t moves = 0;
  if (!(fields >> one.scan >> start >> moves) || !std::getline(fields >> std::ws, words)) {
    return "four fields are expected: scan, start, moves, text";
  }
  const auto scan = graphs.find(one.scan);
  const auto from = scan ? graphs.graph(*scan).find(start) : std::nullopt;
  if (!from) return "no viewpoint " + start + " of a scan " + one.scan;
  one.path = {start};
  one.instructions = {words};
  auto region = region_around(graphs.graph(*scan), *from, moves);
  if (region.viewpoints.empty()) return "no viewpoint is so many moves from the start";
  one.goal = std::move(region);
  return {};
}

// The file as annotations. Every problem goes into one list, nothing is left out silently.
tasks::Annotations read_stay_near(const std::string& text, const graph::GraphSet& graphs) {
  tasks::Annotations annotations{"own", "stay_near.tsv", {}, tasks::Task::kCvdn};
  std::vector<Diagnostic> faults;
  std::istringstream lines(text);
  std::string line;
  for (std::int64_t number = 1; std::getline(lines, line); ++number) {
    tasks::PathAnnotation one;
    one.path_id = number;
    one.id = std::to_string(number);
    const std::string fault = read_line(line, graphs, one);
    if (fault.empty()) {
      annotations.paths.push_back(std::move(one));
    } else {
      faults.push_back({Severity::kError, annotations.file, "line " + one.id, "bad-line", fault});
    }
  }
  if (!faults.empty()) throw InvalidInput(faults);
  return annotations;
}

// What its table has: whether the region was reached at the end, and the metres walked too much.
constexpr std::array<tasks::ScorerMetric, 2> kMetrics{
    {{"success", "SR", tasks::MeanRule::kPlain, 100}, {"detour"}}};

void score_stay_near(const tasks::ScoredTrajectory& scored, std::span<double> out) {
  const auto& [graph, path, trajectory, options] = scored;
  double walked = 0;
  for (std::size_t i = 1; i < trajectory.points.size(); ++i) {
    walked += graph.distance(trajectory.points[i - 1].viewpoint, trajectory.points[i].viewpoint);
  }
  const ViewpointIndex end = trajectory.points.back().viewpoint;
  out[0] = goal_reached(graph, path, end, tasks::Leg::kOut, 0) ? 1 : 0;
  out[1] = walked - graph.distance(path.viewpoints.front(), end);
}

constexpr tasks::Scorer kScorer{.name = "stay-near",
                                .source = "examples/own_benchmark.cpp",
                                .metrics = kMetrics,
                                .on_graph = score_stay_near,
                                .task = tasks::Task::kCvdn};

// A small file of it, from a data set's own paths.
std::string make_file(const tasks::EpisodeSet& r2r) {
  std::string text;
  for (const tasks::ReferencePath& path : r2r.paths) {
    const graph::NavGraph& graph = r2r.graphs->graph(path.scan);
    text += graph.scan() + '\t' + graph.id(path.viewpoints.front()) + "\t2\tWalk two steps away.\n";
  }
  return text;
}

}  // namespace

int main() {
  const Dataset data("homes");  // made as in render.cpp
  write_file_atomically("stay_near.tsv", make_file(data.episodes("val_unseen")));
  const auto annotations = read_stay_near(read_file("stay_near.tsv"), *data.graphs());
  const auto episodes = tasks::make_episodes(annotations, data.graphs());
  for (const char* name : {"shortest", "random"}) {
    const auto trajectories = run_agent(*make_agent(name), episodes);
    // Results are written and checked as any other benchmark's.
    const auto read = tasks::parse_results(to_json(trajectories, episodes), name, episodes);
    std::cout << name << " on synthetic buildings\n"
              << to_table(compute_score(read.trajectories, episodes, kScorer));
  }
}
