#include "enfilade/report/parts/gallery.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <tuple>
#include <utility>
#include <variant>

#include "enfilade/core/errors.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/names.h"
#include "enfilade/core/rng.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/draw/planned_goal.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::report::parts {
namespace {

constexpr PictureSize kFrameSize{384, 288};
constexpr std::uint32_t kPanoramaWidth = 4 * kClearTexels;  // a face's texels, a pixel each
constexpr Radians kPanoramaBand = degrees(90);              // of its height
constexpr std::uint64_t kRandomSeed = 2018;
constexpr std::size_t kMostOthers = 2;  // agents beside the one that the gallery is about

bool chooses_viewpoints(const std::optional<models::RecordedSplit>& recorded) {
  return recorded && std::holds_alternative<models::DecisionFile>(*recorded);
}

// Lower is better.
std::tuple<bool, bool, bool, std::size_t, double> run_rank(const RunRecord& record,
                                                           const std::set<std::string>& models) {
  const ScoredRun& run = *record.run;
  const bool chooses = chooses_viewpoints(record.recorded);
  return {!models.contains(run.agent), !chooses, !run.agent.starts_with("student"),
          run.split == "val_unseen" ? 0U : (run.split == "val_seen" ? 1U : 2U),
          chooses ? -run.scores.ours.mean("success").mean : 0};
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

// A value as the page has it: a multiple of `unit`.
double rounded(double value, double unit) { return std::round(value / unit) * unit; }

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
    throw LookupError(fmt::format("attention: {} has no viewpoint {}; the file is of other data",
                                  graph.scan(), quote(name)));
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

// By storey; to the centimetre.
Json plan_json(const homes::BuildingPlan& plan) {
  Json storeys = Json::array();
  if (plan.drawn() == nullptr) return storeys;
  for (const draw::UnderlayStorey& storey : plan.underlay.storeys) {
    Json lines = Json::object(), names = Json::array();
    for (const auto& [name, kind] : draw::kUnderlayKinds) {
      lines[name] = draw::line_ends(storey.lines, kind, 0.01);
    }
    for (const draw::UnderlayText& text : storey.texts) {
      names.push_back({text.text, rounded(text.at.x, 0.01), rounded(text.at.y, 0.01)});
    }
    storeys.push_back({{"lines", std::move(lines)}, {"names", std::move(names)}});
  }
  return storeys;
}

Json building_json(const graph::NavGraph& graph, const homes::BuildingPlan& plan) {
  Json x = Json::array(), y = Json::array(), edges = Json::array(), storey = Json::array();
  std::vector<std::size_t> storeys(graph.size(), 0);
  const std::vector<draw::GraphStorey> found = draw::find_storeys(graph);
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
  return {{"x", x},           {"y", y},
          {"storey", storey}, {"storeys", found.size()},
          {"edges", edges},   {"plan", plan_json(plan)}};
}

// Whether all chosen episodes are of these buildings, and others of the split are not.
bool is_narrowed(const tasks::EpisodeSet& episodes, const std::vector<ChosenEpisode>& chosen,
                 const std::set<ScanIndex>& to) {
  const auto is_there = [&](const tasks::Episode& episode) {
    return to.contains(episodes.path_of(episode).scan);
  };
  return !chosen.empty() && !std::ranges::all_of(episodes.episodes, is_there) &&
         std::ranges::all_of(chosen, [&](const ChosenEpisode& one) {
           return is_there(episodes.episodes[one.episode]);
         });
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
  Json panoramas = Json::object();  // looking north, each once
  std::string why_not{};            // a sentence: why the last missing frame is missing

  // The key of the frame, which has the goal's object outlined; null if there are no pictures, or
  // if only frames with an outline are wanted and it has none.
  Json add(const std::string& scan, const Moment& m, const ShownGoal& goal, bool only_outlined) {
    const std::vector<draw::Outline> outlines = draw::goal_outlines(
        goal.graph, goal.goal, m.viewpoint, goal.objects, tasks::Direction{m.heading, m.elevation});
    if (only_outlined && outlines.empty()) return nullptr;
    const std::string key =
        fmt::format("{} {} {:.0f} {:.0f}{}", scan, m.viewpoint.value, to_degrees(m.heading),
                    to_degrees(m.elevation), outlines.empty() ? "" : " " + goal.episode);
    return kept(by_key, key, scan, [&](ScanIndex index) {
      return view_uri(data, {index, m.viewpoint, m.heading, m.elevation}, kFrameSize, outlines);
    });
  }

  // The key of what is all around; null if there are no pictures.
  Json add_panorama(const std::string& scan, ViewpointIndex v) {
    return kept(panoramas, fmt::format("{} {}", scan, v.value), scan, [&](ScanIndex index) {
      return panorama_uri(data, {index, v, Radians(0), Radians(0)}, kPanoramaWidth, kPanoramaBand);
    });
  }

  // The key, under which a new picture is added; null if there is none.
  template <class Make>
  Json kept(Json& pictures, const std::string& key, const std::string& scan, const Make& make) {
    if (pictures.contains(key)) return key;
    const auto picture = make(data.graphs()->at(scan));
    if (!picture) {
      why_not = no_pictures_of(scan);
      return nullptr;
    }
    pictures[key] = *picture;
    return key;
  }
};

// What is recorded of an episode; null if nothing is. One of the two at most.
struct RecordedEpisode {
  const models::EpisodeAttention* attention = nullptr;
  const models::EpisodeDecisions* decisions = nullptr;

  RecordedEpisode(const std::optional<models::RecordedSplit>& split, const std::string& id) {
    if (!split) return;
    if (const auto* file = std::get_if<models::AttentionFile>(&*split)) {
      const auto found = file->find(id);
      if (found != file->end()) attention = &found->second;
    } else {
      const auto& other = std::get<models::DecisionFile>(*split);
      const auto found = other.find(id);
      if (found != other.end()) decisions = &found->second;
    }
  }
  std::vector<Moment> moments(const graph::NavGraph& graph,
                              const tasks::Trajectory& trajectory) const {
    if (attention != nullptr) return moments_of(*attention, graph, trajectory);
    if (decisions != nullptr) return moments_of(*decisions, graph, trajectory);
    return moments_of(trajectory);
  }
  // What the agent read; null if that is not known, or no step has attention to it.
  const std::vector<std::string>* words() const {
    if (attention != nullptr) return &attention->words;
    if (decisions == nullptr) return nullptr;
    const bool attended = std::ranges::any_of(
        decisions->steps, [](const models::DecisionStep& step) { return !step.attention.empty(); });
    return attended ? &decisions->words : nullptr;
  }
};

// How one agent walked an episode: {"agent", "steps", "success", "error", "length", "spl", "words",
// "unknown"}.
Json walk_json(const RunRecord& record, const tasks::EpisodeSet& episodes, std::size_t i,
               Frames& frames, bool side_by_side) {
  const tasks::Episode& episode = episodes.episodes[i];
  const graph::NavGraph& graph = episodes.graph_of(episode);
  const tasks::EpisodeMetrics m = metrics_of(record.run->scores.ours, i);
  const RecordedEpisode recorded(record.recorded, episode.instruction_id);
  const ShownGoal goal{graph, episodes.path_of(episode).goal, episodes.objects.get(),
                       episode.instruction_id};
  Json steps = Json::array();
  const auto& walked = std::get<std::vector<tasks::Trajectory>>(record.run->trajectories);
  for (const Moment& moment : recorded.moments(graph, walked[i])) {
    Json step = moment_json(moment, graph);
    step["frame"] = frames.add(graph.scan(), moment, goal, side_by_side);
    if (side_by_side) step["panorama"] = frames.add_panorama(graph.scan(), moment.viewpoint);
    steps.push_back(std::move(step));
  }
  Json json{{"agent", record.run->agent},
            {"steps", std::move(steps)},
            {"success", m.success == 1},
            {"error", rounded(m.nav_error, 0.01)},
            {"length", rounded(m.trajectory_length, 0.01)},
            {"spl", rounded(m.spl, 0.001)}};
  if (recorded.words() != nullptr) {
    json["unknown"] = Json::array();
    json["words"] = readable_words(*recorded.words(), episode.text, json["unknown"]);
  }
  return json;
}

Json episode_json(const GalleryRun& gallery, const tasks::EpisodeSet& episodes,
                  const ChosenEpisode& chosen, Frames& frames) {
  const tasks::Episode& episode = episodes.episodes[chosen.episode];
  const graph::NavGraph& graph = episodes.graph_of(episode);
  Json reference = Json::array();
  for (const ViewpointIndex v : episodes.path_of(episode).viewpoints) reference.push_back(v.value);
  const double shortest = gallery.run->scores.ours.value(chosen.episode, "shortest");
  Json json{{"kind", chosen.kind},    {"id", episode.instruction_id},
            {"scan", graph.scan()},   {"text", episode.text},
            {"reference", reference}, {"shortest", rounded(shortest, 0.01)}};
  const Json mark = goal_json(episodes.path_of(episode),
                              draw::name_of_goal(episodes, episode, episodes.objects.get()));
  if (!mark.is_null()) json["goal"] = mark;
  const std::vector<std::string> lines = draw::episode_lines(episode);
  // Of a plain instruction the text says it all.
  if (episode.details != tasks::InstructionDetails()) json["lines"] = lines;
  const bool chooses = gallery.shows_decisions();
  json.update(walk_json(gallery, episodes, chosen.episode, frames, chooses));
  if (!chooses) return json;
  json["others"] = Json::array();
  for (const RunRecord& other : gallery.others) {
    json["others"].push_back(walk_json(other, episodes, chosen.episode, frames, true));
  }
  return json;
}

// The file of a model's run; nothing if there is none, or if it is no model's.
std::optional<models::RecordedSplit> recorded_split(const ScoredRun& run,
                                                    const RunDirectory& found) {
  std::optional<models::RecordedSplit> recorded;
  for (const ModelDirectory& model : found.models) {
    if (model.agent != run.agent) continue;
    const auto file = find_text_file(models::ModelFiles{model.folder}.attention(run.split));
    std::error_code code;
    if (std::filesystem::exists(file, code)) recorded = models::load_recorded_split(file);
  }
  return recorded;
}

bool holds(const models::RecordedSplit& recorded, const std::string& id) {
  return std::visit([&id](const auto& file) { return file.contains(id); }, recorded);
}

std::size_t recorded_count(const models::RecordedSplit& recorded) {
  return std::visit([](const auto& file) { return file.size(); }, recorded);
}

// Adds other models, one seed each, on the same split and with records. Models that choose among
// viewpoints come first.
void add_others(GalleryRun& gallery, std::vector<RunRecord>& records) {
  std::set<std::string_view> names{without_seed(gallery.run->agent)};
  std::ranges::stable_sort(records, std::ranges::greater{},
                           [](const RunRecord& one) { return chooses_viewpoints(one.recorded); });
  for (RunRecord& one : records) {
    if (gallery.others.size() == kMostOthers) return;
    if (!one.recorded || one.run->split != gallery.run->split) continue;
    if (names.insert(without_seed(one.run->agent)).second) {
      gallery.others.push_back(std::move(one));
    }
  }
}

}  // namespace

bool GalleryRun::shows_decisions() const {
  return chooses_viewpoints(recorded) || std::ranges::any_of(others, [](const RunRecord& one) {
           return chooses_viewpoints(one.recorded);
         });
}

std::optional<GalleryRun> choose_run(const ScoredRuns& runs, const RunDirectory& found) {
  if (runs.runs.empty()) return std::nullopt;
  std::set<std::string> models;
  for (const ModelDirectory& model : found.models) models.insert(model.agent);
  std::vector<RunRecord> records;
  for (const ScoredRun& run : runs.runs) records.push_back({&run, recorded_split(run, found)});
  // The last of the equally good: Random rather than Shortest, where there is no model.
  RunRecord* best = nullptr;
  for (RunRecord& one : records) {
    if (best == nullptr || run_rank(one, models) < run_rank(*best, models) ||
        (run_rank(one, models) == run_rank(*best, models) && best->run->agent == "shortest")) {
      best = &one;
    }
  }
  GalleryRun gallery{{best->run, std::move(best->recorded)}, {}, {}};
  best->recorded.reset();
  add_others(gallery, records);
  if (!gallery.shows_decisions()) gallery.others.clear();
  if (!gallery.recorded) {
    gallery.no_attention =
        fmt::format("There is no results/{}.attention.json, which trained models leave behind.",
                    gallery.run->split);
  }
  return gallery;
}

std::vector<ChosenEpisode> choose_episodes(const GalleryRun& gallery,
                                           const tasks::EpisodeSet& episodes,
                                           const std::set<ScanIndex>& clear, std::size_t each) {
  std::vector<tasks::EpisodeMetrics> metrics;
  for (std::size_t i = 0; i < gallery.run->scores.ours.episodes; ++i) {
    metrics.push_back(metrics_of(gallery.run->scores.ours, i));
  }
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < metrics.size(); ++i) {
    const std::string& id = episodes.episodes[i].instruction_id;
    if (!gallery.recorded || holds(*gallery.recorded, id)) left.push_back(i);
  }
  const auto is_clear = [&](std::size_t i) {
    return clear.contains(episodes.path_of(episodes.episodes[i]).scan);
  };
  if (std::ranges::any_of(left, is_clear)) std::erase_if(left, std::not_fn(is_clear));
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
                  const std::vector<ChosenEpisode>& chosen, const dataset::Dataset& data,
                  BuildingPlans& plans) {
  Frames frames{data};
  Json all = Json::array(), buildings = Json::object();
  for (const ChosenEpisode& one : chosen) {
    all.push_back(episode_json(gallery, episodes, one, frames));
    const graph::NavGraph& graph = episodes.graph_of(episodes.episodes[one.episode]);
    if (!buildings.contains(graph.scan())) {
      buildings[graph.scan()] = building_json(graph, plans.of(graph));
    }
  }
  Json part{{"agent", gallery.run->agent},
            {"split", gallery.run->split},
            {"successDistance", gallery.run->scores.ours.options.metrics.success_distance},
            {"buildings", std::move(buildings)},
            {"episodes", std::move(all)}};
  if (!frames.panoramas.empty()) part["panoramas"] = std::move(frames.panoramas);
  part["frames"] = std::move(frames.by_key);
  if (part["frames"].empty() && !part.contains("panoramas")) part["noPictures"] = frames.why_not;
  if (!gallery.recorded) part["noAttention"] = gallery.no_attention;
  if (gallery.recorded) part["withAttention"] = recorded_count(*gallery.recorded);
  if (is_narrowed(episodes, chosen, clear_scans(data))) part["leastTexels"] = kClearTexels;
  return part;
}

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
