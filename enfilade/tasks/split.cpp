#include "enfilade/tasks/split.h"

#include <fmt/format.h>
#include <utility>

#include "enfilade/core/gzip.h"
#include "enfilade/core/names.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::tasks {

Split::Split(std::shared_ptr<const EpisodeSet> episodes) : graph_(std::move(episodes)) {
  if (!graph_) throw ArgumentError("episodes: none");
  benchmark_ = &tasks::benchmark(graph_->task);
}

Split::Split(const Benchmark& benchmark, std::shared_ptr<const ContinuousEpisodes> episodes,
             std::shared_ptr<const ExpertWalks> experts)
    : benchmark_(&benchmark), floor_(std::move(episodes)), experts_(std::move(experts)) {
  if (!floor_) throw ArgumentError("episodes: none");
  if (!experts_) experts_ = std::make_shared<const ExpertWalks>();
}

const std::string& Split::name() const noexcept { return graph_ ? graph_->split : floor_->split; }

std::size_t Split::size() const noexcept {
  return graph_ ? graph_->episodes.size() : floor_->episodes.size();
}

bool Split::goals_hidden() const noexcept {
  return graph_ ? tasks::goals_hidden(*graph_) : tasks::goals_hidden(*floor_);
}

std::string Split::id(std::size_t episode) const {
  return graph_ ? graph_->episodes[episode].instruction_id : text_of(floor_->episodes[episode].id);
}

PathSize Split::path_size(std::size_t episode) const {
  if (graph_) {
    const ReferencePath& path = graph_->path_of(graph_->episodes[episode]);
    const graph::NavGraph& graph = graph_->graphs->graph(path.scan);
    return {graph.scan(), path.viewpoints.size(), length_of(path, graph)};
  }
  const ContinuousEpisode& one = floor_->episodes[episode];
  PathSize size{std::string(one.scan()), 1, 0};
  if (!one.reference_path) return size;
  const std::vector<Vec3d>& points = *one.reference_path;
  size.places = points.size();
  for (std::size_t k = 1; k < points.size(); ++k) size.length += length(points[k] - points[k - 1]);
  return size;
}

void require_episodes(const Split& split, const std::string& file) {
  if (split.size() > 0) return;
  refuse(file, "$", "no-episodes",
         fmt::format("split {}: the annotations have no episode, so there is nothing to run or "
                     "score; the export of a collection has the paths whose every instruction was "
                     "walked",
                     quote(split.name())));
}

std::size_t size(const Trajectories& trajectories) noexcept {
  return std::visit([](const auto& all) { return all.size(); }, trajectories);
}

Trajectories parse_trajectories(std::string_view text, const std::string& file, const Split& split,
                                Coverage coverage, std::vector<Diagnostic>* warnings) {
  if (const auto& floor = split.continuous()) {
    return parse_continuous_results(text, file, *floor, coverage);
  }
  Results results = parse_results(text, file, *split.on_graph(), coverage);
  if (warnings != nullptr) {
    warnings->insert(warnings->end(), results.warnings.begin(), results.warnings.end());
  }
  return std::move(results.trajectories);
}

Trajectories load_trajectories(const std::filesystem::path& file, const Split& split,
                               Coverage coverage) {
  const TextFile content(file);
  return parse_trajectories(content.text(), file.string(), split, coverage);
}

Split part_of(const Split& split, Trajectories& trajectories) {
  auto* on_graph = std::get_if<std::vector<Trajectory>>(&trajectories);
  return on_graph == nullptr ? split : Split(part_of(*split.on_graph(), *on_graph));
}

std::string to_json(const Trajectories& trajectories, const Split& split) {
  if (const auto* walks = std::get_if<std::vector<ContinuousResult>>(&trajectories)) {
    return to_json(*walks, *split.continuous(), split.benchmark().form);
  }
  return to_json(std::get<std::vector<Trajectory>>(trajectories), *split.on_graph());
}

}  // namespace enfilade::tasks
