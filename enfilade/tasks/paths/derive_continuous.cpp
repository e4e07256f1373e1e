#include "enfilade/tasks/derive_continuous.h"
#include "enfilade/tasks/benchmark.h"

#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::tasks {
namespace {

std::string id_of(const PathAnnotation& path) {
  return path.id.empty() ? fmt::to_string(path.path_id) : path.id;
}

// The number behind the path's in an instruction's id of RxR.
std::string instruction_number(const std::string& id) {
  return id.substr(id.rfind('_') + 1);  // npos + 1 is 0: a test line's, which is the number alone
}

// What a path's episodes have in common; why there are none.
struct OnFloor {
  std::vector<Vec3d> nodes;
  WalkedNodes walked;
};

class Deriver {
 public:
  Deriver(const Annotations& annotations, const graph::GraphSet& graphs, const EpisodeFloor& floor,
          const DeriveOptions& options)
      : annotations_(annotations),
        graphs_(graphs),
        floor_(floor),
        options_(options),
        paths_(look_up_paths(annotations, graphs)) {
    if (options.vocabulary) encoder_.emplace(*options.vocabulary);
  }

  DerivedEpisodes derive() {
    put_on_floor();
    DerivedEpisodes derived;
    derived.episodes.split = annotations_.split;
    derived.episodes.file = annotations_.file;
    derived.episodes.vocabulary = options_.vocabulary.value_or(InstructionVocabulary());
    for (std::size_t p = 0; p < paths_.size(); ++p) {
      const PathAnnotation& path = annotations_.paths[p];
      std::string why = on_floor_[p].walked.obstacle;
      if (why.empty() && path.instructions.empty()) why = "it has no instruction";
      if (!why.empty()) {
        derived.dropped.push_back({p, id_of(path), path.scan, std::move(why)});
        continue;
      }
      add_episodes(p, derived.episodes.episodes);
    }
    return derived;
  }

 private:
  // Scan by scan, so that a floor needs one building at a time.
  void put_on_floor() {
    on_floor_.resize(paths_.size());
    std::vector<std::size_t> order(paths_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [this](std::size_t p) { return paths_[p].scan.at(); });
    std::vector<std::optional<std::optional<Vec3d>>> nodes;
    for (std::size_t k = 0; k < order.size(); ++k) {
      const ReferencePath& path = paths_[order[k]];
      const graph::NavGraph& graph = graphs_.graph(path.scan);
      if (k == 0 || paths_[order[k - 1]].scan != path.scan) nodes.assign(graph.size(), {});
      on_floor_[order[k]] = put_path(path, graph, nodes);
    }
  }

  OnFloor put_path(const ReferencePath& path, const graph::NavGraph& graph,
                   std::vector<std::optional<std::optional<Vec3d>>>& known) const {
    OnFloor result;
    for (const ViewpointIndex viewpoint : path.viewpoints) {
      auto& node = known[viewpoint.at()];
      if (!node) node = floor_.node_of(graph, viewpoint);
      if (!*node) {
        result.walked.obstacle =
            fmt::format("a body cannot stand at viewpoint {}", graph.id(viewpoint));
        return result;
      }
      result.nodes.push_back(**node);
    }
    result.walked = floor_.walk(graph, result.nodes);
    return result;
  }

  FileId file_id(std::int64_t number) const {
    return annotations_.task == Task::kRxr ? FileId(fmt::to_string(number)) : FileId(number);
  }

  FileId trajectory_id(const PathAnnotation& path) const {
    const std::string id = id_of(path);
    return id == fmt::to_string(path.path_id) ? file_id(path.path_id) : FileId(id);
  }

  Radians start_heading(const PathAnnotation& path) const {
    if (options_.start_headings == StartHeadings::kOfPath) return path.heading;
    Rng random(options_.seed, static_cast<std::uint64_t>(path.path_id));
    return Radians(2 * kPi * random.uniform());
  }

  ContinuousInstruction instruction(const PathAnnotation& path, std::size_t k) const {
    ContinuousInstruction result{path.instructions[k]};
    if (encoder_) result.tokens = encoder_->encode(result.text);
    if (annotations_.task != Task::kRxr) return result;
    const InstructionDetails& details = path.details.at(k);
    result.id = instruction_number(details.id);
    result.language = details.language;
    result.words = details.words;
    return result;
  }

  void add_episodes(std::size_t p, std::vector<ContinuousEpisode>& episodes) const {
    const PathAnnotation& path = annotations_.paths[p];
    const OnFloor& on_floor = on_floor_[p];
    ContinuousEpisode episode;
    episode.trajectory_id = trajectory_id(path);
    episode.scene = scene_of_scan(path.scan, options_.scene_folder);
    episode.start = on_floor.nodes.front();
    episode.rotation = StartRotation::of(start_heading(path));
    if (!path.goal_hidden()) {
      episode.info.emplace();
      episode.info->geodesic_distance = on_floor.walked.geodesic_distance;
      episode.goals = {ContinuousGoal{on_floor.nodes.back(), options_.radius}};
      episode.reference_path = on_floor.nodes;
    }
    if (annotations_.task == Task::kRxr) {
      if (!episode.info) episode.info.emplace();
      episode.info->role = AnnotationRole::kGuide;
    }
    for (std::size_t k = 0; k < path.instructions.size(); ++k) {
      episode.id = file_id(options_.first_id + static_cast<std::int64_t>(episodes.size()));
      episode.instruction = instruction(path, k);
      episodes.push_back(episode);
    }
  }

  const Annotations& annotations_;
  const graph::GraphSet& graphs_;
  const EpisodeFloor& floor_;
  const DeriveOptions& options_;
  std::vector<ReferencePath> paths_;
  std::optional<InstructionEncoder> encoder_;
  std::vector<OnFloor> on_floor_;  // of each path
};

}  // namespace

std::optional<Vec3d> GuessedFloor::node_of(const graph::NavGraph& graph,
                                           ViewpointIndex viewpoint) const {
  Vec3d node = to_double(graph.position(viewpoint));
  node.z += kAboveFloor - static_cast<double>(graph.height(viewpoint));
  return node;
}

WalkedNodes GuessedFloor::walk(const graph::NavGraph& /*graph*/,
                               std::span<const Vec3d> /*nodes*/) const {
  return {};
}

DerivedEpisodes derive_continuous(const Annotations& annotations, const graph::GraphSet& graphs,
                                  const EpisodeFloor& floor, const DeriveOptions& options) {
  if (benchmark(annotations.task).goal != GoalKind::kNearEnd) {
    throw ArgumentError(
        fmt::format("annotations of {}: continuous episodes are made of R2R, R2R-Last, R4R and RxR",
                    benchmark(annotations.task).title));
  }
  check_range("radius", options.radius, 0, std::numeric_limits<double>::max());
  return Deriver(annotations, graphs, floor, options).derive();
}

}  // namespace enfilade::tasks
