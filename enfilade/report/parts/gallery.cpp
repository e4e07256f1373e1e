#include "enfilade/report/parts/gallery.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <tuple>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/draw/episode_text.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/draw/planned_goal.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/report/parts/dataset_parts.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::report::parts {
namespace {

constexpr PictureSize kFrameSize{384, 288};
constexpr std::uint64_t kRandomSeed = 2018;

// One step of an episode: where the agent is, and what it does next.
struct Moment {
  ViewpointIndex viewpoint;
  Radians heading, elevation;
  std::string action;  // empty: the episode is over
  const std::vector<double>* attention = nullptr;
};

// Lower is better.
std::tuple<bool, bool, std::size_t> run_rank(const ScoredRun& run,
                                             const std::set<std::string>& models) {
  return {!models.contains(run.agent), !run.agent.starts_with("student"),
          run.split == "val_unseen" ? 0U : (run.split == "val_seen" ? 1U : 2U)};
}

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

std::vector<Moment> moments_of(const tasks::Trajectory& trajectory) {
  std::vector<Moment> moments;
  const auto& points = trajectory.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool last = i + 1 == points.size();
    moments.push_back({points[i].viewpoint, points[i].heading, points[i].elevation,
                       last ? "end" : action_between(points[i], points[i + 1]), nullptr});
  }
  return moments;
}

// From the attention file. If the agent ran out of steps, its last pose is added.
std::vector<Moment> moments_of(const models::EpisodeAttention& attention,
                               const graph::NavGraph& graph, const tasks::Trajectory& trajectory) {
  std::vector<Moment> moments;
  for (const models::AttentionStep& step : attention.steps) {
    const auto v = graph.find(step.viewpoint);
    if (!v) {
      throw LookupError(
          fmt::format("attention: {} has no viewpoint {:?}; the file is of other data",
                      graph.scan(), step.viewpoint));
    }
    moments.push_back(
        {*v, Radians(step.heading), Radians(step.elevation), step.action, &step.attention});
  }
  if (moments.empty() || moments.back().action != "end") {
    const tasks::TrajectoryPoint& end = trajectory.points.back();
    moments.push_back({end.viewpoint, end.heading, end.elevation, "", nullptr});
  }
  return moments;
}

// The words that the agent read, with <UNK> replaced by the instruction's words; their places are
// added to `unknown`. Of a long instruction the beginning is missing, and some end in <EOS>.
std::vector<std::string> readable_words(const std::vector<std::string>& words,
                                        const std::string& text, Json& unknown) {
  std::vector<std::string> readable = words;
  const std::vector<std::string> tokens = tasks::tokenize(text);
  const bool ends = !words.empty() && words.back() == "<EOS>";
  const std::size_t count = words.size() - (ends ? 1 : 0);
  if (count > tokens.size()) return readable;  // of another text
  for (std::size_t i = 0; i < count; ++i) {
    if (words[i] != "<UNK>") continue;
    readable[i] = tokens[tokens.size() - count + i];
    unknown.push_back(i);
  }
  return readable;
}

double rounded(double value, double unit) { return std::round(value / unit) * unit; }

Json building_json(const graph::NavGraph& graph) {
  Json x = Json::array(), y = Json::array(), edges = Json::array(), storey = Json::array();
  std::vector<std::size_t> storeys(graph.size(), 0);
  const std::vector<draw::Storey> found = draw::find_storeys(graph);
  for (std::size_t s = 0; s < found.size(); ++s) {
    for (const ViewpointIndex v : found[s].viewpoints) storeys[v.at()] = s;
  }
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex v(i);
    x.push_back(rounded(graph.position(v).x, 0.01));
    y.push_back(rounded(graph.position(v).y, 0.01));
    storey.push_back(graph.included(v) ? Json(storeys[i]) : Json(nullptr));
    for (const graph::Edge& edge : graph.edges(v)) {
      if (v < edge.target) edges.push_back({i, edge.target.at()});
    }
  }
  return {{"x", x}, {"y", y}, {"storey", storey}, {"storeys", found.size()}, {"edges", edges}};
}

// What of a goal is to be seen in frames.
struct ShownGoal {
  const graph::NavGraph& graph;
  const tasks::Goal& goal;
  const tasks::ObjectBoxes* objects;
  const std::string& episode;  // instruction id: others look at the same place for other objects
};

// The mark on the map: {"kind", "label", "viewpoints"}; null if the goal is the path's end.
Json goal_json(const tasks::ReferencePath& path, const std::string& name) {
  constexpr const char* kKinds[] = {"turning point", "object", "region", "boxes"};
  const auto goal = draw::planned_goal(path, name);
  if (!goal) return nullptr;
  Json json{{"kind", kKinds[static_cast<std::size_t>(goal->kind)]},
            {"label", goal->label},
            {"viewpoints", Json::array()}};
  for (const ViewpointIndex v : goal->viewpoints) json["viewpoints"].push_back(v.value);
  return json;
}

// The frames of all episodes, each once.
struct Frames {
  const dataset::Dataset& data;
  Json by_key = Json::object();
  std::string why_not{};  // a sentence: why the last missing frame is missing

  // The key of the frame, which has the goal's object outlined; null if there are no pictures.
  Json add(const std::string& scan, const Moment& m, const ShownGoal& goal) {
    const std::vector<draw::Outline> outlines = draw::goal_outlines(
        goal.graph, goal.goal, m.viewpoint, goal.objects, tasks::Direction{m.heading, m.elevation});
    const std::string key =
        fmt::format("{} {} {:.0f} {:.0f}{}", scan, m.viewpoint.value, to_degrees(m.heading),
                    to_degrees(m.elevation), outlines.empty() ? "" : " " + goal.episode);
    if (!by_key.contains(key)) {
      const ScanIndex index = data.graphs()->at(scan);
      const auto picture =
          view_uri(data, {index, m.viewpoint, m.heading, m.elevation}, kFrameSize, outlines);
      if (!picture) {
        why_not = no_pictures_of(scan);
        return nullptr;
      }
      by_key[key] = *picture;
    }
    return key;
  }
};

Json moment_json(const Moment& m, const Json& frame) {
  Json json{{"v", m.viewpoint.value},
            {"heading", rounded(m.heading.value, 0.001)},
            {"elevation", rounded(m.elevation.value, 0.001)},
            {"action", m.action},
            {"frame", frame}};
  if (m.attention != nullptr) {
    json["attention"] = Json::array();
    for (const double weight : *m.attention) json["attention"].push_back(rounded(weight, 1e-4));
  }
  return json;
}

Json episode_json(const GalleryRun& gallery, const tasks::EpisodeSet& episodes,
                  const ChosenEpisode& chosen, Frames& frames) {
  const tasks::Episode& episode = episodes.episodes[chosen.episode];
  const graph::NavGraph& graph = episodes.graph_of(episode);
  const tasks::EpisodeMetrics& m = gallery.run->scores.ours.episodes[chosen.episode];
  const tasks::Trajectory& trajectory = gallery.run->trajectories[chosen.episode];
  const models::EpisodeAttention* attention = nullptr;
  if (gallery.attention) {
    const auto found = gallery.attention->find(episode.instruction_id);
    if (found != gallery.attention->end()) attention = &found->second;
  }
  const tasks::ObjectBoxes* objects = episodes.objects.get();
  const ShownGoal goal{graph, episodes.path_of(episode).goal, objects, episode.instruction_id};
  Json steps = Json::array(), reference = Json::array();
  for (const Moment& moment :
       attention != nullptr ? moments_of(*attention, graph, trajectory) : moments_of(trajectory)) {
    steps.push_back(moment_json(moment, frames.add(graph.scan(), moment, goal)));
  }
  for (const ViewpointIndex v : episodes.path_of(episode).viewpoints) reference.push_back(v.value);
  Json json{{"kind", chosen.kind},
            {"id", episode.instruction_id},
            {"scan", graph.scan()},
            {"text", episode.text},
            {"reference", reference},
            {"steps", steps},
            {"success", m.success == 1},
            {"error", rounded(m.nav_error, 0.01)},
            {"length", rounded(m.trajectory_length, 0.01)},
            {"shortest", rounded(m.shortest, 0.01)},
            {"spl", rounded(m.spl, 0.001)}};
  const Json mark =
      goal_json(episodes.path_of(episode), draw::name_of_goal(episodes, episode, objects));
  if (!mark.is_null()) json["goal"] = mark;
  const std::vector<std::string> lines = draw::episode_lines(episode);
  // Of a plain instruction the text says it all.
  if (episode.details != tasks::InstructionDetails()) json["lines"] = lines;
  if (attention != nullptr) {
    json["unknown"] = Json::array();
    json["words"] = readable_words(attention->words, episode.text, json["unknown"]);
  }
  return json;
}

void load_attention_of(GalleryRun& gallery, const RunDirectory& found) {
  for (const ModelDirectory& model : found.models) {
    if (model.agent != gallery.run->agent) continue;
    const auto file = models::ModelFiles{model.folder}.attention(gallery.run->split);
    std::error_code code;
    if (std::filesystem::exists(file, code)) gallery.attention = models::load_attention(file);
  }
  if (gallery.attention) return;
  gallery.no_attention =
      fmt::format("There is no results/{}.attention.json, which trained models leave behind.",
                  gallery.run->split);
}

}  // namespace

std::optional<GalleryRun> choose_run(const ScoredRuns& runs, const RunDirectory& found) {
  if (runs.runs.empty()) return std::nullopt;
  std::set<std::string> models;
  for (const ModelDirectory& model : found.models) models.insert(model.agent);
  // The last of the equally good: Random rather than Shortest, where there is no model.
  const ScoredRun* best = nullptr;
  for (const ScoredRun& run : runs.runs) {
    if (best == nullptr || run_rank(run, models) < run_rank(*best, models) ||
        (run_rank(run, models) == run_rank(*best, models) && best->agent == "shortest")) {
      best = &run;
    }
  }
  GalleryRun gallery{best, std::nullopt, {}};
  load_attention_of(gallery, found);
  return gallery;
}

std::vector<ChosenEpisode> choose_episodes(const GalleryRun& gallery,
                                           const tasks::EpisodeSet& episodes, std::size_t each) {
  const auto& metrics = gallery.run->scores.ours.episodes;
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < metrics.size(); ++i) {
    const std::string& id = episodes.episodes[i].instruction_id;
    if (!gallery.attention || gallery.attention->contains(id)) left.push_back(i);
  }
  std::set<std::size_t> paths;
  std::vector<ChosenEpisode> chosen;
  const auto take = [&](const char* kind, const auto& suits) {
    std::size_t taken = 0;
    for (const std::size_t i : left) {
      if (taken == each || !suits(metrics[i])) continue;
      if (!paths.insert(episodes.episodes[i].path).second) continue;
      chosen.push_back({kind, i});
      ++taken;
    }
  };
  std::ranges::stable_sort(left, std::ranges::greater{}, [&metrics](std::size_t i) {
    return std::tuple(metrics[i].success, std::round(20 * metrics[i].spl), metrics[i].shortest);
  });
  take("best", [](const tasks::EpisodeMetrics& m) { return m.success == 1; });
  std::ranges::stable_sort(left, std::ranges::greater{},
                           [&metrics](std::size_t i) { return metrics[i].nav_error; });
  take("worst", [](const tasks::EpisodeMetrics& m) { return m.success == 0; });
  Rng rng(kRandomSeed);
  rng.shuffle(std::span(left));
  take("random", [](const tasks::EpisodeMetrics&) { return true; });
  return chosen;
}

Json gallery_part(const GalleryRun& gallery, const tasks::EpisodeSet& episodes,
                  const std::vector<ChosenEpisode>& chosen, const dataset::Dataset& data) {
  Frames frames{data};
  Json all = Json::array(), buildings = Json::object();
  for (const ChosenEpisode& one : chosen) {
    all.push_back(episode_json(gallery, episodes, one, frames));
    const graph::NavGraph& graph = episodes.graph_of(episodes.episodes[one.episode]);
    if (!buildings.contains(graph.scan())) buildings[graph.scan()] = building_json(graph);
  }
  Json part{{"agent", gallery.run->agent},
            {"split", gallery.run->split},
            {"successDistance", gallery.run->scores.ours.options.metrics.success_distance},
            {"buildings", std::move(buildings)},
            {"episodes", std::move(all)}};
  part["frames"] = std::move(frames.by_key);
  if (part["frames"].empty()) part["noPictures"] = frames.why_not;
  if (!gallery.attention) part["noAttention"] = gallery.no_attention;
  if (gallery.attention) part["withAttention"] = gallery.attention->size();
  return part;
}

}  // namespace enfilade::report::parts
