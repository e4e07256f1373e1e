/// \file  Walks of DUET: a batch of episodes from their starts to their ends.
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/agents/experts.h"
#include "enfilade/agents/panorama.h"
#include "enfilade/agents/topological_map.h"
#include "enfilade/core/ids.h"
#include "enfilade/features/object_set.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/duet/duet_network.h"
#include "enfilade/sim/candidates.h"

namespace enfilade::neural::duet {

using agents::TopologicalMap;

/// No label: adds nothing to a loss.
inline constexpr std::int64_t kNoLabel = -100;

/// Viewpoint of an agent, and its view of the 36.
struct ViewpointPose {
  ViewpointIndex viewpoint;
  std::uint32_t view = 12;

  Radians heading() const { return agents::view_heading(view); }
  Radians elevation() const { return agents::view_elevation(view); }
};

/// Features by viewpoint: of its 36 views, and of its objects.
class Surroundings {
 public:
  virtual ~Surroundings() = default;
  /// \param out (36, config.image)
  virtual void views(const graph::NavGraph& graph, ViewpointIndex viewpoint,
                     std::span<float> out) = 0;
  /// The objects of a viewpoint, in their order; the network sees the first 20. None by default.
  virtual std::vector<features::ObjectView> objects(const graph::NavGraph& /*graph*/,
                                                    ViewpointIndex /*viewpoint*/) {
    return {};
  }
  /// \param out (config.object) of object `i` of objects()
  virtual void object(const graph::NavGraph& /*graph*/, ViewpointIndex /*viewpoint*/,
                      std::size_t /*i*/, std::span<float> /*out*/) {}
};

/// What is walked.
struct RolloutEpisode {
  std::string id;
  ScanIndex scan;
  ViewpointIndex start;
  std::uint32_t start_view = 12;          ///< 0..35
  std::vector<std::int64_t> words;        ///< ids, those at both ends included
  std::vector<ViewpointIndex> reference;  ///< the annotated path, start to goal; for labels only
  std::string object;                     ///< the instruction's object; empty: none
};

/// How actions are chosen, and when an episode ends.
enum class RolloutFeedback : std::uint8_t {
  kTeacher,  ///< the labels lead; ends on the goal
  kSample,   ///< drawn from the probabilities; ends on the goal, or silently at a drawn stop
  kGreedy,   ///< the most likely; ends at stop
  kExplore,  ///< likewise, but now and then any open node or stop; ends at stop
};
/// Which node a label names.
enum class Expert : std::uint8_t {
  kReference,  ///< the annotated path's next viewpoint; the trajectory must follow it
  kSpl,        ///< agents::ExpertRule::kSpl
  kNdtw,       ///< agents::ExpertRule::kNdtw
};

struct DuetRolloutOptions {
  RolloutFeedback feedback = RolloutFeedback::kGreedy;
  std::optional<Expert> expert;  ///< none: no labels, no loss
  bool three_losses = false;  ///< map and viewpoint have losses of their own beside the common one
  bool draw_best = false;     ///< kSample takes the most likely instead of drawing
  double explore = 0.6;       ///< probability of kExplore's random choices
  bool dropout = false;
  std::uint64_t seed = 1, stream = 0;  ///< of dropout and draws
};

/// One agent's part of a step.
struct StepRow {
  std::size_t episode = 0;  ///< its place in the batch
  ViewpointPose pose;
  const TopologicalMap* map = nullptr;
  std::vector<TopologicalMap::Node> nodes;  ///< of the map's rows from 1
  std::span<const sim::Candidate> candidates;
  std::size_t views = 0;  ///< tokens that are candidates or views
  std::vector<features::ObjectView> objects;
  std::int64_t choice = 0;  ///< row of the map; 0: stop
  std::int64_t label = kNoLabel, local_label = kNoLabel, object_label = kNoLabel;
  std::optional<ViewpointIndex> goes_to;  ///< no value: it moves no more
  bool ends = false;                      ///< here; then it goes to where stopping was most likely
};
/// Rows are the episodes that have not ended.
struct StepOfAll {
  std::size_t step = 0;
  std::span<const StepRow> rows;
  const Tokens* panorama = nullptr;
  const NavigationInput* input = nullptr;
  const NavigationOutput* output = nullptr;
};
using StepWatcher = std::function<void(const StepOfAll&)>;

/// What became of an episode.
struct EpisodeRollout {
  /// [[start], [a], [b, c], ...]: an entry a decision, with the viewpoints passed through.
  std::vector<std::vector<ViewpointIndex>> path;
  std::vector<std::pair<ViewpointIndex, double>> stop_probabilities;  ///< in order of visiting
  ViewpointIndex stop;  ///< the visited one with the highest
  std::string object;   ///< the answer; empty: none
};

struct Rollout {
  std::vector<EpisodeRollout> episodes;
  at::Tensor loss;  ///< the sum over steps and episodes; not defined without an expert
  std::size_t steps = 0;
  double environment_seconds = 0;  ///< of looking, maps, labels and moving: all but the network
};

/// Computes rollouts for networks whose features have the same sizes. Keeps its data of viewpoints
/// between calls. One thread at a time.
class RolloutRunner {
 public:
  RolloutRunner(std::shared_ptr<const graph::GraphSet> graphs, Surroundings& surroundings);
  RolloutRunner(const RolloutRunner&) = delete;
  RolloutRunner& operator=(const RolloutRunner&) = delete;

  /// Autograd follows it, unless a guard is set.
  /// \throws ArgumentError for kReference off the annotated path, or without a reference
  Rollout run(const DuetNetwork& network, std::span<const RolloutEpisode> episodes,
              const DuetRolloutOptions& options, const StepWatcher& watcher = {});

  /// What it knows of a viewpoint; valid as long as the runner.
  struct SeenViewpoint {
    const agents::Panorama* panorama = nullptr;
    at::Tensor views;                           ///< (36, image)
    std::vector<features::ObjectView> objects;  ///< 20 at most
    at::Tensor object_features;                 ///< (objects, object)
  };
  const SeenViewpoint& place(const DuetConfig& config, graph::Location location);
  const graph::NavGraph& graph(ScanIndex scan) const { return graphs_->graph(scan); }
  /// The views of places, on a device that is not the CPU; the first one asked for.
  core::ResidentViews& views_on(c10::Device device, const DuetConfig& config);

 private:
  std::shared_ptr<const graph::GraphSet> graphs_;
  Surroundings& surroundings_;
  agents::PanoramaCache panoramas_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::unique_ptr<SeenViewpoint>> places_;
  std::optional<core::ResidentViews> resident_;
};

}  // namespace enfilade::neural::duet
