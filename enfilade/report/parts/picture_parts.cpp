#include "enfilade/report/parts/parts.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <span>
#include <utility>
#include <variant>

#include "enfilade/core/base64.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/dataset/views.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/draw/planned_goal.h"
#include "enfilade/draw/top_down.h"
#include "enfilade/image/codecs.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::report::parts {
namespace {

using Walks = std::vector<tasks::ContinuousResult>;

constexpr PictureSize kExampleSize{480, 360};
constexpr std::uint32_t kBuildingWidth = 4 * kClearTexels;  // a face's texels, a pixel each
constexpr std::uint64_t kExampleSeed = 2018;                // any: the same data give the same page

// Pictures are drawn larger and averaged: a pixel of a small picture covers several texels, and
// without averaging it would show noise.
constexpr std::uint32_t kOversampling = 3;
constexpr int kJpegQuality = 78;                 // the frames of a gallery take 10 to 20 kB each
constexpr Radians kVerticalField = degrees(60);  // what the agents see

image::Image8 averaged(const image::Image8& large) {
  return image::shrink(large, large.width / kOversampling, large.height / kOversampling);
}

std::string encode(const image::Image8& picture) {
  const std::vector<std::uint8_t> jpeg = image::encode_jpeg(picture, kJpegQuality);
  return data_uri("image/jpeg", {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
}

// Of a picture of all directions.
image::Image8 middle_rows(const image::Image8& picture, Radians band) {
  const auto rows = static_cast<std::uint32_t>(std::lround(picture.width * band.value / (2 * kPi)));
  if (rows >= picture.height) return picture;
  image::Image8 part(picture.width, rows, picture.channels);
  const auto* first = picture.at(0, (picture.height - rows) / 2);
  std::copy_n(first, part.pixels.size(), part.pixels.begin());
  return part;
}

const tasks::Annotations* example_split(const std::vector<tasks::Annotations>& splits) {
  for (const char* wanted : {"val_unseen", "val_seen", "train"}) {
    for (const tasks::Annotations& split : splits) {
      if (split.split == wanted && !split.paths.empty()) return &split;
    }
  }
  return nullptr;
}

std::vector<std::size_t> random_order(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  Rng rng(kExampleSeed);
  rng.shuffle(std::span(order));
  return order;
}

ViewpointIndex busiest(const graph::NavGraph& graph) {
  ViewpointIndex best;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const ViewpointIndex v(i);
    if (graph.edges(v).size() > graph.edges(best).size()) best = v;
  }
  return best;
}

// The first viewpoint with pictures counts. 0: there are none, or they are broken, which is told if
// one of them is to be shown.
std::uint32_t texels_of(const scan::PanoramaSet& panoramas, ScanIndex scan) {
  try {
    const scan::PanoramaSource* source = panoramas.find_source(scan);
    for (std::size_t v = 0; source != nullptr && v < source->size(); ++v) {
      const std::uint32_t size = source->face_sizes(ViewpointIndex(v))[index(scan::Layer::kColour)];
      if (size > 0) return size;
    }
  } catch (const Error&) {
  }
  return 0;
}

// In degrees, clockwise from north, as people read it.
int whole_degrees(Radians heading) { return static_cast<int>(to_degrees(heading) + 0.5) % 360; }

// Each agent's first run on a split, in the order of the runs.
std::vector<const ScoredRun*> first_runs(const ScoredRuns& runs, const std::string& split) {
  std::vector<const ScoredRun*> first;
  std::set<std::string_view> agents;
  for (const ScoredRun& run : runs.runs) {
    if (run.split == split && agents.insert(without_seed(run.agent)).second) first.push_back(&run);
  }
  return first;
}

// By how far from the goal a run stopped. Its walks are in the order of the episodes.
std::vector<ChosenEpisode> choose_walks(const ScoredRun& run, std::size_t of_a_kind) {
  std::vector<std::size_t> order(run.scores.ours.episodes);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&run](std::size_t k) {
    return std::pair(-run.scores.ours.value(k, "spl"),
                     run.scores.ours.value(k, "distance_to_goal"));
  });
  const Walks& walks = std::get<Walks>(run.trajectories);
  std::vector<ChosenEpisode> chosen;
  std::set<std::size_t> taken;
  const auto take = [&](const char* kind, std::size_t place) {
    const std::size_t k = order[std::min(place, order.size() - 1)];
    if (taken.insert(k).second) chosen.push_back({kind, walks[k].episode});
  };
  for (std::size_t i = 0; i < of_a_kind; ++i) take("best", i);
  for (std::size_t i = 0; i < of_a_kind; ++i) take("median", order.size() / 2 + i);
  for (std::size_t i = 0; i < of_a_kind; ++i)
    take("worst", order.size() - 1 - std::min(i, order.size() - 1));
  return chosen;
}

Json map_of(const ChosenEpisode& one, const std::vector<const ScoredRun*>& agents,
            const tasks::ContinuousEpisodes& episodes, const continuous::Buildings& buildings,
            bool synthetic) {
  const tasks::ContinuousEpisode& episode = episodes.episodes.at(one.episode);
  const std::string scan(episode.scan());
  std::vector<draw::WalkedLine> lines;
  if (episode.reference_path)
    lines.push_back({draw::PathRole::kReference, *episode.reference_path, ""});
  Json ends = Json::array();
  for (const ScoredRun* run : agents) {
    const Walks& walks = std::get<Walks>(run->trajectories);
    for (std::size_t k = 0; k < walks.size(); ++k) {
      if (walks[k].episode != one.episode) continue;
      lines.push_back(
          {draw::PathRole::kAgent, draw::walked_points(walks[k].positions), run->agent});
      ends.push_back({{"agent", run->agent},
                      // null if it is not finite
                      {"distance", run->scores.ours.value(k, "distance_to_goal")},
                      {"success", run->scores.ours.value(k, "success") > 0}});
    }
  }
  draw::TopDownOptions options;
  options.title = fmt::format("{}, episode {} ({}){}", scan, tasks::text_of(episode.id), one.kind,
                              synthetic ? " (SYNTHETIC)" : "");
  options.note = episode.instruction.text;
  const std::string svg =
      draw::top_down_svg(buildings.floor(buildings.at(scan)).polygons(), lines, options);
  return {{"scan", scan},
          {"episode", tasks::text_of(episode.id)},
          {"kind", one.kind},
          {"agents", std::move(ends)},
          {"picture", data_uri("image/svg+xml", svg)}};
}

}  // namespace

std::string data_uri(std::string_view type, std::string_view bytes) {
  std::string text = fmt::format("data:{};base64,", type);
  append_base64(std::as_bytes(std::span(bytes)), text);
  return text;
}

std::optional<std::string> view_uri(const dataset::Dataset& data, const render::View& view,
                                    PictureSize size, std::span<const draw::Outline> outlines) {
  if (!has_colour(data, view.scan, view.viewpoint)) return std::nullopt;
  image::Image8 picture = averaged(render_colour(
      data, view, {size.width * kOversampling, size.height * kOversampling, kVerticalField}));
  for (const draw::Outline& outline : outlines) {
    draw_outline(picture, outline, {view.heading, view.elevation}, kVerticalField);
  }
  return encode(picture);
}

std::optional<std::string> panorama_uri(const dataset::Dataset& data, const render::View& view,
                                        std::uint32_t width, Radians band) {
  if (!has_colour(data, view.scan, view.viewpoint)) return std::nullopt;
  return encode(middle_rows(averaged(render_panorama(data, view, width * kOversampling)), band));
}

std::set<ScanIndex> clear_scans(const dataset::Dataset& data) {
  std::set<ScanIndex> clear, all;
  for (std::size_t s = 0; s < data.graphs()->size(); ++s) {
    all.insert(ScanIndex(s));
    if (texels_of(*data.panoramas(), ScanIndex(s)) >= kClearTexels) clear.insert(ScanIndex(s));
  }
  return clear.empty() ? all : clear;
}

const homes::BuildingPlan& BuildingPlans::of(const graph::NavGraph& graph) {
  const auto found = plans_.find(graph.scan());
  if (found != plans_.end()) return found->second;
  homes::BuildingPlan plan;
  try {
    plan = homes::read_building_plan(data_.folder(), data_.panorama_places().images, graph);
  } catch (const FileError&) {  // a list of another version: drawn without walls
  }
  return plans_.emplace(graph.scan(), std::move(plan)).first->second;
}

std::string no_pictures_of(std::string_view scan) {
  return fmt::format("The data set has no pictures of {}.", scan);
}

Json examples_part(const std::vector<tasks::Annotations>& splits, const dataset::Dataset& data,
                   std::size_t count) {
  const tasks::Annotations* split = example_split(splits);
  if (split == nullptr) return missing("There are no annotations in the data set.");
  Json all = Json::array();
  std::string why;
  const std::set<ScanIndex> clear = clear_scans(data);
  std::vector<std::size_t> order = random_order(split->paths.size());
  std::ranges::stable_partition(order, [&](std::size_t i) {
    const auto scan = data.graphs()->find(split->paths[i].scan);
    return scan && clear.contains(*scan);
  });
  for (const std::size_t i : order) {
    if (all.size() == count) break;
    const tasks::PathAnnotation& path = split->paths[i];
    if (path.instructions.empty()) continue;
    const auto start = find_view(data, {path.scan, path.path.front(), path.heading, Radians(0)});
    const auto picture = view_uri(data, start, kExampleSize);
    if (!picture) why = no_pictures_of(path.scan);
    all.push_back({{"scan", path.scan},
                   {"path", path.path_id},
                   {"heading", whole_degrees(path.heading)},
                   {"instructions", path.instructions},
                   {"picture", picture ? Json(*picture) : Json(nullptr)}});
  }
  Json part{{"split", split->split}, {"paths", std::move(all)}};
  if (!why.empty()) part["noPictures"] = why;
  return part;
}

Json panoramas_part(const dataset::Dataset& data, std::size_t most) {
  const graph::GraphSet& graphs = *data.graphs();
  const std::set<ScanIndex> clear = clear_scans(data);
  const std::vector<ScanIndex> from(clear.begin(), clear.end());
  const std::size_t shown = std::min(from.size(), most);
  Json all = Json::array();
  std::string why;
  for (std::size_t k = 0; k < shown; ++k) {
    const ScanIndex scan = from[k * from.size() / shown];
    const graph::NavGraph& graph = graphs.graph(scan);
    if (graph.included_count() == 0) continue;
    const ViewpointIndex v = busiest(graph);
    const Radians heading = graph.edges(v).empty() ? Radians(0) : graph.edges(v).front().heading;
    const auto picture = panorama_uri(data, {scan, v, heading, {}}, kBuildingWidth);
    if (!picture) {
      why = no_pictures_of(graph.scan());
      continue;
    }
    all.push_back({{"scan", graph.scan()},
                   {"viewpoint", graph.id(v)},
                   {"viewpoints", graph.included_count()},
                   {"picture", *picture}});
  }
  if (all.empty()) return missing(why);
  Json part{{"buildings", graphs.size()}};
  if (from.size() < graphs.size()) part["leastTexels"] = kClearTexels;
  part["panoramas"] = std::move(all);
  return part;
}

Json plans_part(const ScoredRun& run, const tasks::EpisodeSet& episodes,
                const std::vector<ChosenEpisode>& chosen, BuildingPlans& plans) {
  const tasks::ObjectBoxes* objects = episodes.objects.get();
  const auto& trajectories = std::get<std::vector<tasks::Trajectory>>(run.trajectories);
  Json all = Json::array();
  for (const ChosenEpisode& one : chosen) {
    const tasks::Episode& episode = episodes.episodes[one.episode];
    const graph::NavGraph& graph = episodes.graph_of(episode);
    draw::PlannedPath reference{draw::PathRole::kReference, episodes.path_of(episode).viewpoints,
                                "reference path"};
    draw::PlannedPath agent{draw::PathRole::kAgent, {}, run.agent};
    for (const tasks::TrajectoryPoint& point : trajectories[one.episode].points) {
      agent.viewpoints.push_back(point.viewpoint);
    }
    draw::FloorPlanOptions options;
    options.title =
        fmt::format("{}, episode {} ({})", graph.scan(), episode.instruction_id, one.kind);
    options.underlay = plans.of(graph).drawn();
    options.lines = draw::episode_lines(episode);
    options.goal = draw::planned_goal(episodes.path_of(episode),
                                      draw::name_of_goal(episodes, episode, objects));
    const std::string svg = draw::floor_plan_svg(graph, {reference, agent}, options);
    all.push_back({{"scan", graph.scan()},
                   {"episode", episode.instruction_id},
                   {"kind", one.kind},
                   {"picture", data_uri("image/svg+xml", svg)}});
  }
  return {{"agent", run.agent}, {"split", run.split}, {"plans", std::move(all)}};
}

Json walks_part(const ScoredRuns& runs, std::size_t of_a_kind, bool synthetic) {
  if (runs.runs.empty()) return missing("There are no results that can be scored.");
  const bool unseen = std::ranges::any_of(
      runs.runs, [](const ScoredRun& run) { return run.split == "val_unseen"; });
  const std::string split = unseen ? "val_unseen" : runs.runs.front().split;
  const std::vector<const ScoredRun*> agents = first_runs(runs, split);
  const ScoredRun* judge = agents.back();
  for (const ScoredRun* run : agents) {
    if (!is_oracle(run->agent)) judge = run;
  }
  Json all = Json::array();
  for (const ChosenEpisode& one : choose_walks(*judge, of_a_kind)) {
    all.push_back(
        map_of(one, agents, *runs.split_of(*judge).continuous(), *runs.buildings, synthetic));
  }
  return {{"agent", judge->agent}, {"split", split}, {"walks", std::move(all)}};
}

}  // namespace enfilade::report::parts
