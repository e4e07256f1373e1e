/// \file  The state of one episode of a rollout, and the network's inputs from many.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "enfilade/agents/topological_map.h"
#include "enfilade/neural/duet/rollout.h"

namespace enfilade::neural::duet {

/// One episode. Embeddings are by the map's nodes.
class DuetEpisodeState {
 public:
  DuetEpisodeState(const RolloutEpisode& episode, std::size_t number, const graph::NavGraph& graph);

  /// What it sees where it stands becomes part of the map; `step` is that of the visit.
  void look(const RolloutRunner::SeenViewpoint& place, std::size_t step);
  /// The node where it stands, and the open ones that are seen from it, have embeddings now.
  /// \param mean row of the pool with the mean of its panorama's tokens
  /// \param first row of the pool with its first token
  void embed(std::int64_t mean, std::int64_t first);
  /// Goes to a node by known ways and takes the view in which the viewpoint before it has it.
  void go(TopologicalMap::Node node, RolloutRunner& runner, const DuetConfig& config);
  /// What the network says of a visited viewpoint. \param best_object empty: none is there
  void remember(ViewpointIndex viewpoint, double stop_probability, std::string best_object);
  /// After a stop: goes to the visited viewpoint with the highest probability of stopping, if any.
  void finish(agents::FinalStop rule);
  std::vector<ViewpointIndex> walked() const;  ///< all viewpoints so far

  const RolloutEpisode* episode;
  std::size_t number;
  const graph::NavGraph* graph;
  ViewpointPose pose;
  TopologicalMap map;
  const RolloutRunner::SeenViewpoint* place = nullptr;
  /// Per node, rows of the pool; their mean is the node's embedding. A visited node has one row,
  /// which is a mean itself. An open node has the rows of the tokens that have shown it.
  std::vector<std::vector<std::int64_t>> embeddings;
  std::vector<std::string> objects;  ///< the best at each visited node; empty: none
  agents::StopMemory stops;
  EpisodeRollout walk;
  bool ended = false;

 private:
  TopologicalMap::Node node() const { return *map.find(pose.viewpoint); }
};

/// Word ids and their numbers, padded. At most config.max_words of each episode are taken.
std::pair<at::Tensor, at::Tensor> words_of(std::span<const RolloutEpisode> episodes,
                                           const DuetConfig& config);
PanoramaInput panorama_of(std::span<DuetEpisodeState* const> states, const DuetConfig& config);
/// Someone who looks around.
struct Stand {
  const RolloutRunner::SeenViewpoint* place = nullptr;
  ViewpointPose pose;
};
PanoramaInput panorama_of(std::span<const Stand> stands, const DuetConfig& config);
/// The same with the views on a card; all else is on the CPU.
PanoramaInput panorama_of(std::span<DuetEpisodeState* const> states, const DuetConfig& config,
                          core::ResidentViews& views);
/// All of navigation_of() but what is learned: nodes, tokens and their mask stay undefined.
/// \param tokens of the longest panorama \param rows each map's rows()
NavigationInput places_of(std::span<DuetEpisodeState* const> states,
                          std::span<const std::vector<TopologicalMap::Node>> rows,
                          std::int64_t tokens, const DuetConfig& config);
/// \param rows each map's rows()
/// \param pool (rows, hidden) what EpisodeState::embeddings name
NavigationInput navigation_of(std::span<DuetEpisodeState* const> states,
                              std::span<const std::vector<TopologicalMap::Node>> rows,
                              const Tokens& panorama, const at::Tensor& pool,
                              const DuetConfig& config);

}  // namespace enfilade::neural::duet
