#include "enfilade/report/parts/moments.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "enfilade/core/errors.h"
#include "enfilade/report/parts/dataset_parts.h"

namespace enfilade::report::parts {
namespace {

// The action between two poses; results files do not contain actions.
std::string action_between(const tasks::TrajectoryPoint& a, const tasks::TrajectoryPoint& b) {
  constexpr double kStill = 0.01;  // radians: files are written with a few digits
  if (a.viewpoint != b.viewpoint) return "forward";
  const double turn = wrap_difference(b.heading - a.heading).value;
  if (std::abs(turn) > kStill) return turn > 0 ? "right" : "left";
  const double raised = b.elevation.value - a.elevation.value;
  if (std::abs(raised) > kStill) return raised > 0 ? "up" : "down";
  return "wait";
}

ViewpointIndex find_viewpoint(const graph::NavGraph& graph, const std::string& name) {
  const auto v = graph.find(name);
  if (!v) {
    throw LookupError(fmt::format("attention: {} has no viewpoint {:?}; the file is of other data",
                                  graph.scan(), name));
  }
  return *v;
}

bool neighbours(const graph::NavGraph& graph, ViewpointIndex a, ViewpointIndex b) {
  return std::ranges::any_of(graph.edges(a),
                             [b](const graph::Edge& edge) { return edge.target == b; });
}

std::string action_of(const models::DecisionStep& step, const graph::NavGraph& graph,
                      ViewpointIndex here) {
  const std::string& to = step.choices.at(step.chosen).viewpoint;
  if (to.empty()) return "end";
  const bool near =
      step.way.empty() ? neighbours(graph, here, find_viewpoint(graph, to)) : step.way.size() == 1;
  return near ? "go" : "jump";
}

Json shares_json(const models::Choice& choice) {
  Json json{{"p", rounded(choice.probability, 1e-4)}};
  if (choice.map) json["map"] = rounded(*choice.map, 1e-4);
  if (choice.view) json["view"] = rounded(*choice.view, 1e-4);
  return json;
}

Json choice_json(const models::Choice& choice, const graph::NavGraph& graph, ViewpointIndex here) {
  Json json{{"v", nullptr}};
  json.update(shares_json(choice));
  if (choice.viewpoint.empty()) return json;
  const ViewpointIndex there = find_viewpoint(graph, choice.viewpoint);
  json["v"] = there.value;
  if (there != here && neighbours(graph, here, there)) {
    const Vec3f way = graph.position(there) - graph.position(here);
    json["heading"] = rounded(std::atan2(double{way.x}, double{way.y}), 0.001);
    json["elevation"] =
        rounded(std::atan2(double{way.z}, std::hypot(double{way.x}, double{way.y})), 0.001);
  }
  return json;
}

void add_decision(Json& json, const models::DecisionStep& step, const graph::NavGraph& graph,
                  ViewpointIndex here) {
  json["choices"] = Json::array();
  for (const models::Choice& choice : step.choices) {
    json["choices"].push_back(choice_json(choice, graph, here));
  }
  json["chosen"] = step.chosen;
  json["way"] = Json::array();
  for (const std::string& name : step.way) {
    json["way"].push_back(find_viewpoint(graph, name).value);
  }
  if (step.map_share) json["share"] = rounded(*step.map_share, 1e-4);
  if (!step.object.empty()) json["object"] = step.object;
  if (step.nodes.empty()) return;
  json["nodes"] = Json::array();
  for (const models::MapNode& node : step.nodes) {
    json["nodes"].push_back({find_viewpoint(graph, node.viewpoint).value, node.visited,
                             node.stop ? Json(rounded(*node.stop, 1e-4)) : Json(nullptr)});
  }
}

}  // namespace

double rounded(double value, double unit) { return std::round(value / unit) * unit; }

std::vector<Moment> moments_of(const tasks::Trajectory& trajectory) {
  std::vector<Moment> moments;
  const auto& points = trajectory.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool last = i + 1 == points.size();
    moments.push_back({points[i].viewpoint, points[i].heading, points[i].elevation,
                       last ? "end" : action_between(points[i], points[i + 1])});
  }
  return moments;
}

std::vector<Moment> moments_of(const models::EpisodeAttention& attention,
                               const graph::NavGraph& graph, const tasks::Trajectory& trajectory) {
  std::vector<Moment> moments;
  for (const models::AttentionStep& step : attention.steps) {
    moments.push_back({find_viewpoint(graph, step.viewpoint), Radians(step.heading),
                       Radians(step.elevation), step.action, &step.attention});
  }
  if (moments.empty() || moments.back().action != "end") {
    const tasks::TrajectoryPoint& end = trajectory.points.back();
    moments.push_back({end.viewpoint, end.heading, end.elevation, ""});
  }
  return moments;
}

std::vector<Moment> moments_of(const models::EpisodeDecisions& decisions,
                               const graph::NavGraph& graph, const tasks::Trajectory& trajectory) {
  std::vector<Moment> moments;
  for (const models::DecisionStep& step : decisions.steps) {
    const ViewpointIndex here = find_viewpoint(graph, step.viewpoint);
    moments.push_back({here, Radians(step.heading), Radians(step.elevation),
                       action_of(step, graph, here),
                       step.attention.empty() ? nullptr : &step.attention, &step});
  }
  const tasks::TrajectoryPoint& end = trajectory.points.back();
  const bool stopped = !moments.empty() && moments.back().action == "end";
  if (!stopped || moments.back().viewpoint != end.viewpoint) {
    moments.push_back({end.viewpoint, end.heading, end.elevation, stopped ? "back" : ""});
  }
  return moments;
}

Json moment_json(const Moment& m, const graph::NavGraph& graph) {
  Json json{{"v", m.viewpoint.value},
            {"heading", rounded(m.heading.value, 0.001)},
            {"elevation", rounded(m.elevation.value, 0.001)},
            {"action", m.action}};
  if (m.attention != nullptr) {
    json["attention"] = Json::array();
    for (const double weight : *m.attention) json["attention"].push_back(rounded(weight, 1e-4));
  }
  if (m.decision != nullptr) add_decision(json, *m.decision, graph, m.viewpoint);
  return json;
}

}  // namespace enfilade::report::parts
