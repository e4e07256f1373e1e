#include "enfilade/draw/planned_goal.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cctype>
#include <variant>

#include "enfilade/core/written_lists.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::draw {
namespace {

using GoalKind = PlannedGoal::GoalMark;

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
  constexpr std::string_view kBlanksAndStops = " \t\r\n.";
  const std::size_t begin = name.find_first_not_of(kBlanksAndStops);
  if (begin == std::string_view::npos) return {};
  name = name.substr(begin, name.find_last_not_of(kBlanksAndStops) + 1 - begin);
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

struct DrawnMark {
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
  return std::visit(DrawnMark{what}, path.goal);
}

std::string name_of_goal(const tasks::EpisodeSet& episodes, const tasks::Episode& episode,
                         const tasks::ObjectBoxes* objects) {
  const tasks::ReferencePath& path = episodes.path_of(episode);
  if (const auto* object = std::get_if<tasks::SeenObject>(&path.goal)) {
    return objects == nullptr ? "" : name_of_object(*objects, episodes.graph_of(episode), *object);
  }
  if (std::holds_alternative<tasks::Region>(path.goal)) return target_of(episode.text);
  if (const auto* boxes = std::get_if<tasks::Boxes>(&path.goal)) {
    // An instruction's own words for it may be a sentence: "Find the orange pair of shoes."
    for (const tasks::Box& box : boxes->boxes) {
      if (std::string name = without_article(box.object); !name.empty()) return name;
    }
  }
  for (const auto& [name, text] : episode.details.fields) {
    if (name == "obj_name") return without_article(text);
  }
  return {};
}

namespace {

constexpr std::string_view kTarget = "<TAR>";

std::string line_of(const tasks::DialogueTurn& turn) {
  std::string role = turn.role.empty() ? "somebody" : turn.role;
  role[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(role[0])));
  const std::string when = turn.nav_step == 0 ? ""
                                              : fmt::format(", after {} step{}", turn.nav_step,
                                                            turn.nav_step == 1 ? "" : "s");
  return fmt::format("{}{}: {}", role, when, trimmed(turn.message));
}

std::string line_of(const tasks::SubInstruction& part, std::size_t number) {
  std::string line = fmt::format("{}. {}", number, fmt::join(part.words, " "));
  if (!part.places) return line;
  const auto [first, last] = *part.places;
  return line + (first == last ? fmt::format(" (viewpoint {})", first + 1)
                               : fmt::format(" (viewpoints {} to {})", first + 1, last + 1));
}

}  // namespace

std::string target_of(std::string_view text) {
  const std::size_t at = text.rfind(kTarget);
  return at == std::string_view::npos ? "" : std::string(trimmed(text.substr(at + kTarget.size())));
}

std::vector<std::string> episode_lines(const tasks::Episode& episode) {
  std::vector<std::string> lines;
  const tasks::InstructionDetails& details = episode.details;
  if (!details.language.empty()) lines.push_back("Language: " + details.language);
  for (const tasks::DialogueTurn& turn : details.turns) lines.push_back(line_of(turn));
  const std::string target = target_of(episode.text), text(trimmed(episode.text));
  if (!target.empty()) {
    lines.push_back("Looking for: " + target);
  } else if (!text.empty() && details.turns.empty()) {
    lines.push_back("\u201c" + text + "\u201d");
  }
  std::size_t number = 0;
  for (const tasks::SubInstruction& part : details.parts) lines.push_back(line_of(part, ++number));
  for (const auto& [name, value] : details.fields) {
    if (!value.empty()) lines.push_back(fmt::format("{}: {}", name, value));
  }
  return lines;
}

}  // namespace enfilade::draw
