/// \file  The recorded episodes of DUET, and what they are walked with.
#pragma once
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enfilade/dataset/dataset.h"
#include "enfilade/neural/duet/duet_network.h"
#include "enfilade/neural/duet/rollout.h"
#include "tests/conformance/agents_golden.h"
#include "tests/conformance/tensor_numbers.h"

namespace enfilade::tests {

/// SYNTHETIC features, which are formulas of names, and the objects of the data set's boxes.
class NamedSurroundings : public neural::duet::Surroundings {
 public:
  explicit NamedSurroundings(const dataset::Dataset& data) : data_(data) {}
  void views(const graph::NavGraph& graph, ViewpointIndex viewpoint, std::span<float> out) override;
  std::vector<features::ObjectView> objects(const graph::NavGraph& graph,
                                            ViewpointIndex viewpoint) override;
  void object(const graph::NavGraph& graph, ViewpointIndex viewpoint, std::size_t i,
              std::span<float> out) override;

 private:
  const dataset::Dataset& data_;
};

/// An episode of a recording, as it is walked.
neural::duet::RolloutEpisode duet_episode(const nlohmann::json& record,
                                          const graph::GraphSet& graphs);

/// Training's episodes: those of the recording, and all of REVERIE's own files.
class TrainingEpisodes {
 public:
  TrainingEpisodes(const std::vector<nlohmann::json>& records, const dataset::Dataset& data);
  /// \throws std::out_of_range for an unknown id
  std::vector<neural::duet::RolloutEpisode> batch(const nlohmann::json& ids) const;

 private:
  void add(const nlohmann::json& items, const graph::GraphSet& graphs);
  std::map<std::string, neural::duet::RolloutEpisode> episodes_;
};

/// The network of `duet_<task>.pt`, which takes 100 words at most.
neural::duet::DuetNetwork duet_network(const AgentsFolder& folder, const std::string& task);

/// `duet_units.*`
void check_duet_units(const AgentsFolder& folder, AgentsTally& tally);
/// `duet_<task>_training.json.gz`
void check_duet_training(const AgentsFolder& folder, const std::string& task, AgentsTally& tally);

}  // namespace enfilade::tests
