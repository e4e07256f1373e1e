/// \file  The state of one episode of a rollout, and the network's inputs from many.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "enfilade/agents/final_stop.h"
#include "enfilade/neural/duet/rollout.h"

namespace enfilade::neural::duet {

/// One episode. Embeddings are by the map's nodes.
class WalkState {
 public:
  WalkState(const WalkEpisode& episode, std::size_t number, const graph::NavGraph& graph);

  /// What it sees where it stands becomes part of the map; `step` is that of the visit.
  void look(const Walker::Place& place, std::size_t step);
  /// Embeddings of the node where it stands and of the open ones that are seen from it.
  /// \param tokens (tokens, hidden) of its panorama, without padding
  void embed(const at::Tensor& tokens);
  /// Goes to a node by known ways and takes the view in which the viewpoint before it has it.
  void go(TopologicalMap::Node node, Walker& walker, const DuetConfig& config);
  /// What the network says where it stands. \param best_object empty: none is there
  void remember(double stop_probability, std::string best_object);
  /// The walk to the visited viewpoint with the highest probability of stopping.
  void walk_to_best();
  std::vector<ViewpointIndex> walked() const;  ///< all viewpoints so far

  const WalkEpisode* episode;
  std::size_t number;
  const graph::NavGraph* graph;
  Pose pose;
  TopologicalMap map;
  const Walker::Place* place = nullptr;
  std::vector<at::Tensor> embeddings;  ///< visited: the mean; open: the sum
  std::vector<std::int64_t> shown;     ///< how many embeddings are in the sum
  std::vector<std::string> objects;    ///< the best where it has been; empty: none
  agents::StopMemory stops;
  Walk walk;
  bool ended = false;

 private:
  TopologicalMap::Node node() const { return *map.find(pose.viewpoint); }
};

/// Word ids and their numbers, padded. At most config.max_words of each episode are taken.
std::pair<at::Tensor, at::Tensor> words_of(std::span<const WalkEpisode> episodes,
                                           const DuetConfig& config);
PanoramaInput panorama_of(std::span<WalkState* const> states, const DuetConfig& config);
/// \param rows each map's rows()
NavigationInput navigation_of(std::span<WalkState* const> states,
                              std::span<const std::vector<TopologicalMap::Node>> rows,
                              const Tokens& panorama, const DuetConfig& config);

}  // namespace enfilade::neural::duet
