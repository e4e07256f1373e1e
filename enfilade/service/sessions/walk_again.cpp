#include "enfilade/service/sessions/walk_again.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>
#include <variant>

#include "enfilade/arena/wire.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/errors.h"
#include "enfilade/service/sessions/sessions.h"
#include "enfilade/tasks/results.h"

namespace enfilade::service::sessions {
namespace {

using nlohmann::ordered_json;

/// Whether a session and a transcript observe the same place. Only fields that identify the place
/// are compared: later versions may put the rest in other words.
bool is_same_place(const ordered_json& told, const ordered_json& seen) {
  for (const char* name : {"step", "here", "heading", "elevation"}) {
    if (!told.contains(name) || told[name] != seen.at(name)) return false;
  }
  const ordered_json& places = seen.at("places");
  if (!told.contains("places") || told["places"].size() != places.size()) return false;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const ordered_json& place = told["places"][k];
    if (!place.is_object()) return false;
    for (const char* name : {"name", "turn", "elevation", "distance"}) {
      if (!place.contains(name) || place[name] != places[k].at(name)) return false;
    }
  }
  return true;
}

/// Where a session stands and looks, degrees, how it came there, and which viewpoints the places
/// are. \param walked points of its trajectory that were told before; then all that there are
ordered_json place_of(const arena::GraphSession& session, const graph::NavGraph& graph,
                      std::size_t& walked) {
  const arena::GraphPose pose = session.pose();
  ordered_json at{{"viewpoint", graph.id(pose.location.viewpoint)},
                  {"heading", to_degrees(pose.heading)},
                  {"elevation", to_degrees(pose.elevation)}};
  ordered_json& path = at["path"] = ordered_json::array();
  const auto trajectory = std::get<tasks::Trajectory>(session.walked());
  for (; walked < trajectory.points.size(); ++walked) {
    path.push_back(graph.id(trajectory.points[walked].viewpoint));
  }
  ordered_json& places = at["places"] = ordered_json::object();
  for (const arena::Neighbour& one : session.observation().places) {
    places[one.name] = graph.id(session.viewpoint_of(one.name));
  }
  return at;
}

}  // namespace

std::size_t walk_again(const std::shared_ptr<const Site>& site, const EpisodePlace& place,
                       const Transcript& transcript, const AtStep& at_step) {
  const tasks::Annotations& all = place.split->annotations;
  // Only one path of the split: the replay needs no other.
  const auto world =
      graph_world(site, {all.split, all.file, {*place.path}, all.task}, tasks::Instructions::kAll);
  const tasks::EpisodeSet& set = *world->episodes().on_graph();
  const graph::NavGraph& graph = set.graph_of(set.episodes.at(place.number));
  const std::vector<TranscriptStep>& steps = transcript.steps;
  // Its end is the transcript's: no limit of another run ends it before.
  const auto most = static_cast<std::uint32_t>(steps.size() + 1);
  const auto session = world->start_on_graph(place.number, {most, most});
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const auto seen = ordered_json::parse(to_json(session->observation()));
    const bool same = !session->ending() && is_same_place(steps[k].shown.at("observation"), seen);
    if (!same) return k + 1;
    if (!at_step(k, *session, graph)) return 0;
    if (steps[k].call) {
      session->call(*steps[k].call);
    } else {
      session->misread("no call");
    }
  }
  at_step(steps.size(), *session, graph);
  return 0;
}

std::string add_places(const std::shared_ptr<const Site>& site, const Run& run,
                       std::string_view episode, Transcript& transcript, ordered_json& out) {
  if (run.is_continuous()) return "the steps of a walk in continuous space have no viewpoints";
  const EpisodePlace* place = run.find(episode);
  if (place == nullptr) {
    return "this server has no such episode, so where the steps were is not known";
  }
  std::size_t walked = 0;
  const auto at_step = [&](std::size_t k, const arena::GraphSession& session,
                           const graph::NavGraph& graph) {
    const bool is_end = k == transcript.steps.size();
    ordered_json& shown = is_end ? transcript.end : transcript.steps[k].shown;
    shown["at"] = place_of(session, graph, walked);
    if (is_end) return true;
    auto captions = ordered_json::array();
    for (const auto& one : pictures_sent(*site, transcript.steps[k], session, run.picture_size)) {
      captions.push_back(one.caption);
    }
    if (!captions.empty()) shown["pictures"] = std::move(captions);
    return true;
  };
  try {
    out["scan"] = place->path->scan;
    const std::size_t different = walk_again(site, *place, transcript, at_step);
    if (different == 0) return {};
    return fmt::format(
        "walked again, step {} comes out differently from the transcript: the data set here is "
        "another one, or the file was changed. From there on the places are not known",
        different);
  } catch (const Error&) {  // what it says may name files of this machine
    return "the episode cannot be walked again here, so where the steps were is not known";
  }
}

std::vector<arena::PictureOrder> pictures_sent(const Site& site, const TranscriptStep& step,
                                               const arena::GraphSession& session,
                                               std::uint32_t pixels) {
  if (step.pictures.empty()) return {};
  const arena::GraphPose pose = session.pose();
  const auto* source = site.panoramas().find_source(pose.location.scan);
  if (source == nullptr ||
      !source->find(site.graphs().graph(pose.location.scan).id(pose.location.viewpoint))) {
    return {};  // there is nothing to draw them from
  }
  const bool strip = step.pictures.front().starts_with("strip/");
  std::vector<arena::PictureOrder> orders = arena::order_pictures(
      session, strip ? arena::PictureKind::kStrip : arena::PictureKind::kPlaces, pixels);
  const bool same = std::ranges::equal(orders, step.pictures, {}, &arena::PictureOrder::key);
  return same ? std::move(orders) : std::vector<arena::PictureOrder>();
}

}  // namespace enfilade::service::sessions
