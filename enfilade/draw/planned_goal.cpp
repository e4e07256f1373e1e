#include "enfilade/draw/planned_goal.h"

#include <fmt/format.h>
#include <algorithm>
#include <variant>

#include "enfilade/draw/episode_text.h"

namespace enfilade::draw {
namespace {

using GoalKind = PlannedGoal::Kind;

std::string counted(std::size_t count) {
  return fmt::format(" ({} viewpoint{})", count, count == 1 ? "" : "s");
}

std::string name_of_object(const tasks::ObjectBoxes& objects, const graph::NavGraph& graph,
                           const tasks::SeenObject& goal) {
  for (const ViewpointIndex v : goal.seen_from) {
    for (const tasks::ViewedObject& object : objects.at(graph.scan(), graph.id(v))) {
      if (object.id == goal.id) return object.name.substr(0, object.name.find('#'));
    }
  }
  return {};
}

// "The vase. " as "vase".
std::string without_article(std::string_view name) {
  constexpr std::string_view kAround = " \t\r\n.";
  const std::size_t begin = name.find_first_not_of(kAround);
  if (begin == std::string_view::npos) return {};
  name = name.substr(begin, name.find_last_not_of(kAround) + 1 - begin);
  for (const std::string_view article : {"The ", "the ", "A ", "a ", "An ", "an "}) {
    if (name.starts_with(article)) return std::string(name.substr(article.size()));
  }
  return std::string(name);
}

PlannedGoal with(GoalKind kind, std::vector<ViewpointIndex> viewpoints, const std::string& label) {
  std::ranges::sort(viewpoints);
  viewpoints.erase(std::ranges::unique(viewpoints).begin(), viewpoints.end());
  const std::string count = kind == GoalKind::kTurningPoint ? "" : counted(viewpoints.size());
  return {kind, std::move(viewpoints), label + count};
}

struct Mark {
  std::string_view what;

  std::string named(const char* verb, const char* unnamed) const {
    return what.empty() ? fmt::format("{} {}", verb, unnamed)
                        : fmt::format("{} the {}", verb, what);
  }
  std::optional<PlannedGoal> operator()(const tasks::NearEnd& /*goal*/) const {
    return std::nullopt;
  }
  std::optional<PlannedGoal> operator()(const tasks::HiddenGoal& /*goal*/) const {
    return std::nullopt;
  }
  std::optional<PlannedGoal> operator()(const tasks::TurningPoint& goal) const {
    return with(GoalKind::kTurningPoint, {goal.viewpoint}, "turning point");
  }
  std::optional<PlannedGoal> operator()(const tasks::SeenObject& goal) const {
    return with(GoalKind::kObject, goal.seen_from,
                named("sees", fmt::format("object {}", goal.id).c_str()));
  }
  std::optional<PlannedGoal> operator()(const tasks::Region& goal) const {
    return with(GoalKind::kRegion, goal.viewpoints,
                what.empty() ? "region of the goal" : fmt::format("region of the {}", what));
  }
  std::optional<PlannedGoal> operator()(const tasks::Boxes& goal) const {
    std::vector<ViewpointIndex> viewpoints;
    for (const tasks::Box& box : goal.boxes) viewpoints.push_back(box.viewpoint);
    return with(GoalKind::kBoxes, std::move(viewpoints), named("shows", "the object"));
  }
};

}  // namespace

std::optional<PlannedGoal> planned_goal(const tasks::ReferencePath& path, std::string_view what) {
  return std::visit(Mark{what}, path.goal);
}

std::string name_of_goal(const tasks::EpisodeSet& episodes, const tasks::Episode& episode,
                         const tasks::ObjectBoxes* objects) {
  const tasks::ReferencePath& path = episodes.path_of(episode);
  if (const auto* object = std::get_if<tasks::SeenObject>(&path.goal)) {
    return objects == nullptr ? "" : name_of_object(*objects, episodes.graph_of(episode), *object);
  }
  if (std::holds_alternative<tasks::Region>(path.goal)) return target_of(episode.text);
  for (const auto& [name, text] : episode.details.fields) {
    if (name == "obj_name") return without_article(text);
  }
  return {};
}

}  // namespace enfilade::draw
