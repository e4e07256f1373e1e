/// \file  The episodes of EnvDrop's recordings, to be walked again.
#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "enfilade/neural/panoramic/panoramic_episode.h"
#include "enfilade/neural/panoramic/panoramic_network.h"
#include "tests/conformance/agents_golden.h"
#include "tests/conformance/tensor_numbers.h"

namespace enfilade::tests {

/// At most `count` of some numbers.
std::span<const double> first(const std::vector<double>& values, std::size_t count);

/// The network with the weights of one of the folder's files.
neural::panoramic::PanoramicNetwork network_of(const AgentsFolder& folder, const std::string& name,
                                               neural::panoramic::Subout subout);

/// One of them.
struct EnvdropEpisode {
  std::string id;
  neural::panoramic::ListenerStart start;
  std::vector<std::int64_t> words;
  const nlohmann::json* recorded = nullptr;
};

/// All of them, and what is needed to walk them.
class EnvdropEpisodes {
 public:
  /// \param lines of `envdrop_episodes.jsonl.gz`; outlive it
  /// \throws LookupError for a scan or viewpoint that the data set has not
  EnvdropEpisodes(const dataset::Dataset& data, const std::vector<nlohmann::json>& lines);
  EnvdropEpisodes(const EnvdropEpisodes&) = delete;
  EnvdropEpisodes& operator=(const EnvdropEpisodes&) = delete;

  const EnvdropEpisode& at(const std::string& id) const { return episodes_.at(id); }
  const std::map<std::string, EnvdropEpisode>& all() const { return episodes_; }
  const graph::NavGraph& graph_of(const EnvdropEpisode& episode) const;
  /// SYNTHETIC pictures.
  const neural::panoramic::ImageSource& images() const { return images_; }
  std::vector<neural::panoramic::PanoramicEpisode> walks(const std::vector<std::string>& ids);
  neural::panoramic::WordBatch words(const std::vector<std::string>& ids) const;

 private:
  void add(const nlohmann::json& recorded);

  std::shared_ptr<const graph::GraphSet> graphs_;
  agents::PanoramaCache panoramas_;
  std::map<std::string, EnvdropEpisode> episodes_;
  neural::panoramic::ImageSource images_;
};

/// Compares a row of a step of a rollout with its recording, before the move.
class EnvdropRow {
 public:
  EnvdropRow(const neural::panoramic::PanoramicStep& step, std::size_t row,
             const graph::NavGraph& graph, std::string name, AgentsTally& tally)
      : step_(step),
        row_(row),
        walk_(step.walks[row]),
        graph_(graph),
        name_(std::move(name)),
        tally_(tally) {}

  /// What training and evaluation have in common.
  void check_choice(const nlohmann::json& recorded);
  /// What evaluation alone has.
  void check_pose(const nlohmann::json& recorded);

 private:
  void check_candidates(const nlohmann::json& recorded);
  at::Tensor row(const at::Tensor& all) const;

  const neural::panoramic::PanoramicStep& step_;
  std::size_t row_;
  const neural::panoramic::PanoramicEpisode& walk_;
  const graph::NavGraph& graph_;
  std::string name_;
  AgentsTally& tally_;
};

/// `envdrop_training.json.gz`, and the checkpoint after its last two iterations.
void check_envdrop_training(const AgentsFolder& folder, AgentsTally& tally);

}  // namespace enfilade::tests
