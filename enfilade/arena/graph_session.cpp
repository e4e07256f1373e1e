#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "enfilade/agents/episode_batch.h"
#include "enfilade/agents/topological_map.h"
#include "enfilade/arena/detail/texts.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/errors.h"
#include "enfilade/draw/outlines.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::arena {
namespace {

using agents::TopologicalMap;
using Node = TopologicalMap::Node;

/// Directions of look(), and how far each turns.
struct Look {
  std::string_view name;
  double right = 0, up = 0;  // degrees
};
constexpr std::array kLooks{Look{"left", -90}, Look{"right", 90}, Look{"behind", 180},
                            Look{"up", 0, 30}, Look{"down", 0, -30}};
constexpr double kSteepest = 30;  // degrees: the rows of the 36 views

ToolUse look_tool() {
  ToolUse use{Tool::kLook, "direction", {}};
  for (const Look& one : kLooks) use.allowed.emplace_back(one.name);
  return use;
}

sim::SimulatorConfig one_walker() {
  sim::SimulatorConfig config = sim::SimulatorConfig::room_to_room();
  config.batch_size = 1;
  return config;
}

class OneGraphSession : public GraphSession {
 public:
  OneGraphSession(GraphWorld& world, std::size_t episode, const SessionLimits& limits)
      : GraphSession(limits), world_(world), batch_(*world.episodes().on_graph(), one_walker()) {
    batch_.begin(0, episode);
    heading_ = wrap_heading(Radians(batch_.state().heading[0]));
    arrive();
    begin();
  }

  GraphPose pose() const override { return {location(), heading_, elevation_}; }
  std::size_t episode() const override { return batch_.index(0); }
  ViewpointIndex viewpoint_of(std::string_view place) const override {
    return map_.viewpoint(detail::number_of_letters(place));
  }
  std::int64_t object_of(std::string_view thing) const override {
    return visible().at(number_of(std::string(thing)))->id;
  }
  Walked walked() const override { return batch_.trajectory(0); }
  std::string episode_id() const override { return batch_.episode(0).instruction_id; }
  Standpoint standpoint() const override {
    const graph::NavGraph& graph = batch_.graph(0);
    return {graph.scan(), graph.id(location().viewpoint), location(), heading_, elevation_};
  }

 protected:
  void carry_out(Tool tool, const std::vector<std::string>& values) override {
    switch (tool) {
      case Tool::kGoTo:
      case Tool::kBackTo:
        return go(detail::number_of_letters(values[0]));
      case Tool::kLook:
        return look(values[0]);
      case Tool::kTurnBack:
        batch_.give(0, {.turning_point = location().viewpoint});
        return tell(
            fmt::format("You said that the way back begins at {}.", detail::letters(here())));
      case Tool::kAnswer:
        batch_.give(0, {.object = std::to_string(object_of(values[0]))});
        tell(fmt::format("You named object {} and stopped.", values[0]));
        break;
      default:
        tell("You stopped.");
    }
    batch_.end(0);
    end(Ending::kStopped);
  }

  void look_around(SessionObservation& seen) override {
    seen.instruction = batch_.episode(0).text;
    seen.heading = heading_;
    seen.elevation = elevation_;
    seen.here = detail::letters(here());
    list_places(seen);
    list_things(seen);
    list_map(seen);
    list_tools(seen);
  }

 private:
  graph::Location location() const {
    return {batch_.path(0).scan, ViewpointIndex(batch_.state().viewpoint[0])};
  }
  const std::vector<sim::Candidate>& candidates() const {
    return world_.panoramas().at(location()).candidates;
  }
  Node here() const { return map_.find(location().viewpoint).value(); }
  static std::size_t number_of(const std::string& name) { return std::stoul(name) - 1; }

  void arrive() {
    new_here_.clear();
    for (const sim::Candidate& one : candidates()) {
      if (!map_.find(one.viewpoint)) new_here_.insert(one.viewpoint.value);
    }
    map_.arrive(batch_.graph(0), location().viewpoint, candidates(), observation().step);
  }

  void go(Node to) {
    const double metres = map_.distance(here(), to);
    std::vector<ViewpointIndex> path;
    map_.path(here(), to, path);
    const ViewpointIndex last = path.size() > 1 ? path[path.size() - 2] : location().viewpoint;
    const auto view =
        agents::arrival_view(world_.panoramas().at({location().scan, last}), path.back());
    batch_.walk(0, path, view.value_or(agents::level_view(heading_)));
    heading_ = wrap_heading(Radians(batch_.state().heading[0]));
    elevation_ = Radians(0);
    arrive();
    tell(fmt::format("You went to {}, {:.1f} m.", detail::letters(to), metres));
  }

  void look(const std::string& direction) {
    const auto look = std::ranges::find(kLooks, direction, &Look::name);
    heading_ = wrap_heading(heading_ + degrees(look->right));
    const double up = to_degrees(elevation_) + look->up;
    elevation_ = look->up == 0 ? Radians(0) : degrees(std::clamp(up, -kSteepest, kSteepest));
    tell(fmt::format("You look {}.", direction));
  }

  void list_places(SessionObservation& seen) const {
    seen.places.clear();
    for (const sim::Candidate& one : candidates()) {
      const Node node = map_.find(one.viewpoint).value();
      seen.places.push_back({detail::letters(node), wrap_difference(one.heading - heading_),
                             one.elevation, one.distance, map_.visited(node),
                             !new_here_.contains(one.viewpoint.value)});
    }
    std::ranges::stable_sort(seen.places, {}, [](const Neighbour& p) { return p.turn.value; });
    Standpoint from = standpoint();
    for (Neighbour& place : seen.places) {
      from.heading = wrap_heading(heading_ + place.turn);
      from.elevation = place.elevation;
      place.what = world_.words_of(from);
    }
  }

  std::vector<const tasks::ViewedObject*> visible() const {
    std::vector<const tasks::ViewedObject*> found;
    for (const tasks::ViewedObject& one : batch_.observation(0).objects) {
      if (one.visible()) found.push_back(&one);
    }
    return found;
  }

  void list_things(SessionObservation& seen) const {
    seen.things.clear();
    for (const tasks::ViewedObject* one : visible()) {
      const std::size_t box = draw::best_box(*one);
      const tasks::Direction middle =
          draw::centre_of(draw::outline_of_box(one->views[box], one->boxes[box]));
      seen.things.push_back({std::to_string(seen.things.size() + 1),
                             one->name.substr(0, one->name.find('#')),
                             wrap_difference(middle.heading - heading_), middle.elevation});
    }
  }

  void list_map(SessionObservation& seen) const {
    seen.map.clear();
    for (const Node node : map_.visits()) {
      MappedPlace& place = seen.map.emplace_back();
      place.name = detail::letters(node);
      std::vector<Node> next;
      for (const sim::Candidate& one :
           world_.panoramas().at({location().scan, map_.viewpoint(node)}).candidates) {
        next.push_back(map_.find(one.viewpoint).value());
      }
      std::ranges::sort(next);
      for (const Node one : next) place.leads_to.push_back(detail::letters(one));
    }
  }

  void list_tools(SessionObservation& seen) const {
    seen.tools.clear();
    ToolUse go{Tool::kGoTo, "place", {}};
    for (const Neighbour& place : seen.places) go.allowed.push_back(place.name);
    ToolUse back{Tool::kBackTo, "place", {}};
    for (const Node node : map_.visits()) {
      if (node != here()) back.allowed.push_back(detail::letters(node));
    }
    if (!go.allowed.empty()) seen.tools.push_back(std::move(go));
    if (!back.allowed.empty()) seen.tools.push_back(std::move(back));
    seen.tools.push_back(look_tool());
    if (batch_.episodes().task == tasks::Task::kR2rBack) {
      seen.tools.push_back({Tool::kTurnBack, {}, {}});
    }
    if (batch_.episodes().task == tasks::Task::kReverie) {
      ToolUse answer{Tool::kAnswer, "object", {}};
      for (const VisibleObject& thing : seen.things) answer.allowed.push_back(thing.name);
      if (!answer.allowed.empty()) seen.tools.push_back(std::move(answer));
    }
    seen.tools.push_back({Tool::kStop, {}, {}});
  }

  GraphWorld& world_;
  agents::EpisodeBatch batch_;
  TopologicalMap map_;
  std::set<std::uint32_t> new_here_;  // viewpoints that were seen from here for the first time
  Radians heading_, elevation_;
};

}  // namespace

std::vector<ToolUse> GraphWorld::tools() const {
  std::vector<ToolUse> all{{Tool::kGoTo, "place", {}}, {Tool::kBackTo, "place", {}}, look_tool()};
  const tasks::Task task = episodes().on_graph()->task;
  if (task == tasks::Task::kR2rBack) all.push_back({Tool::kTurnBack, {}, {}});
  if (task == tasks::Task::kReverie) all.push_back({Tool::kAnswer, "object", {}});
  all.push_back({Tool::kStop, {}, {}});
  return all;
}

std::unique_ptr<GraphSession> GraphWorld::start_on_graph(std::size_t episode,
                                                         const SessionLimits& limits) {
  check(episode, limits);
  if (episodes().benchmark().task == tasks::Task::kSoon) {
    throw ArgumentError(fmt::format("{}: a session has no tool for the answer that it asks for",
                                    episodes().benchmark().title));
  }
  return std::make_unique<OneGraphSession>(*this, episode, limits);
}

}  // namespace enfilade::arena
