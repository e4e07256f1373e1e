/// \file  The secret goals of secret_phase.h as the split "test" of every benchmark, and results
/// files of each. All SYNTHETIC.
#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/continuous/navigation_mesh.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/split.h"
#include "tests/support/made_meshes.h"
#include "tests/support/secret_phase.h"
#include "tests/support/served_benchmarks.h"

namespace enfilade::service::testing {

/// A point of continuous episodes, by the viewpoint above it. Goals lie a little further, so that
/// no distance is exactly the 3 m of success.
inline Vec3d floor_below(double viewpoint) { return {viewpoint, 0, 0}; }
inline constexpr double kFurther = 0.1;

/// \param goals null: without goals
inline tasks::ContinuousEpisodes hall_episodes(const Goals* goals) {
  tasks::ContinuousEpisodes hall;
  hall.split = "test";
  for (std::size_t path = 0; path < kPaths; ++path) {
    tasks::ContinuousEpisode& e = hall.episodes.emplace_back();
    e.id = e.trajectory_id = static_cast<std::int64_t>(path) + 1;
    e.scene = "mp3d/hall/hall.glb";
    e.start = floor_below(static_cast<double>(path));
    e.rotation = tasks::StartRotation::of(degrees(90));
    e.instruction.text = "Walk down the hall.";
    e.instruction.id = std::to_string(path + 1);
    if (goals == nullptr) continue;
    const Vec3d end = floor_below(static_cast<double>(path + kNearest + (*goals)[path]) + kFurther);
    e.goals = {{{end, 3}}};
    e.reference_path = {{e.start, end}};
  }
  return hall;
}

/// The text of a benchmark's split.
inline std::string hall_split(const tasks::Benchmark& benchmark, const Goals* goals) {
  if (benchmark.continuous()) return gzip(to_json(hall_episodes(goals)), 6);
  std::vector<json> entries;
  for (std::size_t path = 0; path < kPaths; ++path) {
    // Its goal is kNearest + candidate viewpoints away, its object 100 + kCandidates * path +
    // candidate.
    HiddenThings things;
    if (goals != nullptr) {
      things.more_steps = (*goals)[path] + kNearest - 2;
      things.more_id = static_cast<int>(40 + (kCandidates - 1) * path + (*goals)[path]);
    }
    entries.push_back(
        served_entry(benchmark.task, path, goals == nullptr ? nullptr : &things, "hall"));
  }
  return served_text(benchmark.task, entries);
}

/// Each object of hall_split() is seen from its own viewpoint only.
inline std::string hall_boxes() {
  json boxes;
  for (std::size_t path = 0; path < kPaths; ++path) {
    for (std::size_t candidate = 0; candidate < kCandidates; ++candidate) {
      const std::string id = std::to_string(100 + kCandidates * path + candidate);
      boxes["hall_" + viewpoint(path + kNearest + candidate)][id] = {
          {"name", "vase"}, {"visible_pos", {0}}, {"bbox2d", {{1, 2, 30, 40}}}};
    }
  }
  return boxes.dump();
}

/// Where the goals of a benchmark are, in the folder above the data set.
inline std::string secret_file(const tasks::Benchmark& benchmark) {
  return std::string("secret/") + std::string(benchmark.name);
}

/// Writes the split "test" of all benchmarks into a data set, and their goals beside it.
/// \pre the data set has the hall (Target)
inline void write_secret_benchmarks(const std::filesystem::path& root, const Goals& goals) {
  const auto write = [&root](const std::filesystem::path& file, const std::string& text) {
    make_folder((root / file).parent_path());
    write_file_atomically(root / file, text);
  };
  const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(
      mesh::testing::Maker().room(-1, -1, static_cast<double>(kLength) + 1, 1).mesh));
  for (const tasks::Benchmark& one : tasks::benchmarks()) {
    write("data" / tasks::episode_places(one, "test").front(), hall_split(one, nullptr));
    write(secret_file(one), hall_split(one, &goals));
    if (!one.continuous()) continue;
    const std::filesystem::path floors = root / "data/navmesh" / one.name;
    make_folder(floors);
    continuous::save_navigation_mesh(mesh::make_floor_polygons(tracer), floors / "hall.navmesh");
  }
  write("data" / tasks::object_places().front(), hall_boxes());
}

/// The pieces of a walk over the floor.
inline tasks::ContinuousResult on_floor(std::size_t path, const Walk& walk) {
  constexpr int kPieces = 4;  // 0.25 m each
  tasks::ContinuousResult result;
  const auto add = [&result](double at) {
    const Vec3d point = floor_below(at);
    result.positions.push_back(to_float(point));
    result.headings.push_back(degrees(90));
  };
  std::vector<std::size_t> steps = walk.steps();
  add(static_cast<double>(path));
  for (std::size_t k = 1; k < steps.size(); ++k) {
    for (int piece = 1; piece <= kPieces; ++piece) {
      const double from = static_cast<double>(steps[k - 1]), to = static_cast<double>(steps[k]);
      add(static_cast<double>(path) + from + (to - from) * piece / kPieces);
      result.actions.push_back(1);
    }
  }
  add(static_cast<double>(path + steps.back()));
  result.actions.push_back(tasks::ContinuousResult::kStop);
  return result;
}

/// A walk over the graph, from the viewpoint of that number; there and back for R2R-Back.
inline tasks::Trajectory on_graph(const tasks::Benchmark& benchmark, std::size_t start,
                                  const Walk& walk) {
  tasks::Trajectory trajectory;
  const auto add = [&](std::size_t step) {
    trajectory.points.push_back({ViewpointIndex(start + step), Radians(1.5), Radians(0)});
  };
  for (const std::size_t step : walk.steps()) add(step);
  if (benchmark.answer == tasks::AnswerKind::kTurningPoint) {
    trajectory.turning_point = trajectory.points.back().viewpoint;
    for (std::size_t step = walk.end; step-- > 0;) add(step);
  }
  return trajectory;
}

/// A results file of the split "test", as the library writes it.
inline std::string results_of(const tasks::Split& split, const Walks& walks) {
  const tasks::Benchmark& benchmark = split.benchmark();
  if (const auto& floor = split.continuous()) {
    std::vector<tasks::ContinuousResult> results;
    for (std::size_t path = 0; path < floor->episodes.size(); ++path) {
      results.push_back(on_floor(path, walks[path]));
      results.back().episode = path;
    }
    return to_json(tasks::Trajectories(std::move(results)), split);
  }
  std::vector<tasks::Trajectory> results;
  for (std::size_t e = 0; e < split.size(); ++e) {
    const tasks::EpisodeSet& set = *split.on_graph();
    const std::size_t path = set.path_of(set.episodes[e]).viewpoints.front().at();
    results.push_back(on_graph(benchmark, path, walks[path]));
    results.back().episode = e;
  }
  return to_json(tasks::Trajectories(std::move(results)), split);
}

}  // namespace enfilade::service::testing
